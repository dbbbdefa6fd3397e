"""The simulation behind deploy/growth.md: it repeats itself, what was measured, and its page."""

import dataclasses
import re
import subprocess
import sys

import pytest

from harness import ROOT

HOME = ROOT / "deploy" / "growth"
PAGE = ROOT / "deploy" / "growth.md"
MARGIN = 0.15  # rounds of one measurement differ by as much


@pytest.fixture(scope="module")
def growth():
    """The simulation's modules, as attributes."""
    made = subprocess.run([HOME / "setup"], capture_output=True, text=True, timeout=120)
    if made.returncode != 0:
        pytest.skip(f"SimPy cannot be installed: {made.stderr[-300:]}")
    sys.path[:0] = [str(HOME), str(ROOT / ".cache" / "growth")]
    import measured
    import model
    import tables

    return type("Growth", (), {"measured": measured, "model": model, "tables": tables})


@pytest.fixture(scope="module")
def costs(growth):
    return growth.measured.read()


PLANS = [
    dict(cores=2, threads=2),
    dict(cores=30, envs=4, episodes=64, overlap=1, gigabits=1),
    dict(cores=100, envs=1, episodes=200, minibatches=20, overlap=1, check_share=0.05),
    dict(cores=100, envs=16, episodes=200, epochs=1, threads=64, overlap=1, gigabits=1),
    dict(cores=100, envs=1, episodes=200, epochs=1, threads=64, overlap=1, checkers=2, intakes=2),
]


def test_one_seed_gives_one_outcome_and_another_seed_another(growth, costs):
    plan = growth.model.Plan(cores=20, envs=4, episodes=40, overlap=1)
    first, again, other = (growth.model.simulate(plan, costs, seed=seed) for seed in (1, 1, 2))
    assert first == again
    assert first.steps_per_second != other.steps_per_second


def test_measured_runs_are_reproduced_within_the_margin(growth, costs):
    for what, rate, plan in growth.tables.measured_rates():
        simulated = growth.model.simulate(plan, costs, updates=30).steps_per_second
        assert simulated == pytest.approx(rate, rel=MARGIN), what


def test_the_measured_intake_of_a_learner_is_reproduced_within_the_margin(growth, costs):
    for what, rate, *case in growth.tables.measured_intakes():
        assert growth.tables.simulated_intake(costs, *case) == pytest.approx(rate, rel=MARGIN), what


@pytest.mark.parametrize("words", PLANS)
def test_no_run_is_faster_than_its_smallest_part(growth, costs, words):
    plan = growth.model.Plan(**words)
    steps = growth.measured.STEPS
    heard = plan.participants
    an_episode = max(
        growth.measured.EPISODE_BYTES * 8 / (plan.gigabits * 1e9),
        (costs.receive + heard * costs.fanout) / plan.intakes,
        (costs.handle + heard * costs.assignment + (0 if plan.checkers else plan.check_share * costs.check))
        / plan.intakes,
        plan.check_share * costs.check / max(1, plan.checkers),
        growth.model.update_seconds(plan, costs) / plan.episodes,
        steps * costs.step / plan.cores,
    )
    # An actor's mean duration over some hundred episodes is a sample's; the first batch is early.
    assert growth.model.simulate(plan, costs, 20).steps_per_second < 1.03 * steps / an_episode


def test_more_cores_are_never_slower_where_participants_stay_the_same(growth, costs):
    rates = []
    for cores in (1, 2, 5, 10, 20, 50, 100, 200):
        plan = growth.model.Plan(cores=cores, envs=cores, episodes=400, minibatches=20, overlap=1)
        rates.append(growth.model.simulate(plan, costs, 4).steps_per_second)
    assert all(more > 0.98 * fewer for fewer, more in zip(rates, rates[1:])), rates
    assert rates[3] == pytest.approx(10 * rates[0], rel=0.05)


def test_an_actor_never_plays_more_than_it_has_envs_for(growth, costs):
    for words in PLANS:
        found = growth.model.simulate(growth.model.Plan(**words), costs, 6)
        assert 0 <= found.idle <= 1
        # What was begun before the window counts in it: an episode an env at most.
        assert all(load < 1.05 for part, load in found.loads.items() if part != "presence"), found


def test_what_an_assignment_costs_others_makes_many_small_processes_slower(growth, costs):
    few, many = (
        growth.model.simulate(growth.tables.big(400, envs=envs, epochs=1, threads=64), costs, 3)
        for envs in (16, 1)
    )
    assert many.steps_per_second < few.steps_per_second and many.limit == "receiver"


def test_machines_beyond_the_number_of_groups_make_no_update_faster(growth, costs):
    plan = growth.model.Plan(cores=1, episodes=16, minibatches=8, threads=16, exchange=0, gigabits=1e9)
    some, more = (
        growth.model.minibatch_seconds(dataclasses.replace(plan, learners=machines), costs) for machines in (32, 64)
    )
    assert more == pytest.approx(some)


def test_a_figure_that_is_missing_is_named_with_what_measures_it(growth, tmp_path):
    with pytest.raises(growth.measured.MissingFigure, match="training.csv.*tests/bench/run training"):
        growth.measured.read(folder=tmp_path)


def test_the_tables_of_the_page_are_those_that_the_program_makes(growth, costs):
    """Of what plays on 100 cores at most; the rest takes minutes."""
    page = PAGE.read_text()
    for name, make in growth.tables.TABLES.items():
        (block,) = re.findall(rf"<!-- table {name} -->\n\n(.*?)\n\n<!-- end -->", page, re.DOTALL)
        lines = block.splitlines()
        for made in make(costs, 100).splitlines()[2:]:
            assert any(line.startswith(made) for line in lines), f"{name}: not in {PAGE.name}: {made}"
