"""Experiment fifty: two figures and three tables of all tasks, from what is there."""

import os
import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from matplotlib.colors import to_hex

import cells
import estimates
import experts
import fifty
import names
import published
import style
import synthetic
import traits
from conftest import ROOT
from draw import every_task

BUILD = Path(os.environ.get("METRONOME_BUILD", ROOT / "build"))
BLUE, RED = (names.ARMS[arm].colour.lower() for arm in ("multihead", "ppo"))


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    monkeypatch.setattr(estimates, "RESAMPLES", 20)
    yield
    plt.close("all")


def evaluated(results, task, arm, success, seed=1, **columns):
    """A cell whose last evaluation has this success, and the others that are named."""
    single = arm != "multihead"
    files = synthetic.cell(results, "fifty", task, arm, seed, method="single" if single else "multihead",
                           heads=1 if single else 10, updates=20)
    path, run = files.evaluations_path, f"{task}-{arm}-s{seed}"
    names, *rows = (line.split(",") for line in path.read_text().splitlines())
    last = max(i for i, row in enumerate(rows) if row[0] == run)
    values = dict(zip(names, rows[last])) | {"success": success, "success_end": success, "success_200": success} | columns
    rows[last] = values.values()
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (names, *rows)))


def pair(results, task, heads, ppo, **columns):
    evaluated(results, task, "multihead", heads, **columns)
    evaluated(results, task, "ppo", ppo, **columns)


def read(results):
    return cells.read_results(results)[0]


def tables(results, scripted=None):
    return fifty.tables(read(results), scripted or {})


def row_of(table, begin):
    (row,) = [line for line in table.splitlines() if line.startswith(f"| {begin} |")]
    return row.strip("| ").split(" | ")


def drawn_at(ax, y):
    """Hex of the bar's colour and where it ends; None where there is no bar."""
    bars = [line for line in ax.lines if line.get_linewidth() == 6 and line.get_ydata()[0] == y]
    return (to_hex(bars[0].get_color()), float(bars[0].get_xdata()[1])) if bars else None


def test_each_task_that_has_a_run_has_a_panel_with_its_arms(tmp_path):
    for task in ("push", "assembly", "reach"):
        evaluated(tmp_path, task, "ppo", 0.5)
    evaluated(tmp_path, "push", "multihead", 0.5)
    figure, caption = every_task.fifty(read(tmp_path))
    panels = [ax for ax in figure.axes if ax.get_visible()]
    assert [ax.get_title(loc="left") for ax in panels] == ["assembly", "push", "reach"]
    # Its seed, their mean and a row of marks for each arm.
    assert [len(ax.lines) for ax in panels] == [3, 6, 3]
    assert "3 tasks of the fifty, those with finished runs" in caption and "0 to 1 seeds" in caption


def test_marks_are_the_evaluations_and_stand_side_by_side(tmp_path):
    pair(tmp_path, "push", 0.9, 0.3)
    figure, _ = every_task.fifty(read(tmp_path))
    marks = {to_hex(line.get_color()): line for line in figure.axes[0].lines if line.get_marker() == "o"}
    assert marks[BLUE].get_ydata()[-1] == 0.9 and marks[RED].get_ydata()[-1] == 0.3
    assert len(marks[BLUE].get_xdata()) == 4
    gap = marks[RED].get_xdata() - marks[BLUE].get_xdata()
    assert gap == pytest.approx([every_task._BESIDE * 800_000] * 4)


def test_a_ragged_last_row_has_its_steps_labelled(tmp_path):
    for task in ("assembly", "basketball", "push", "reach", "soccer", "sweep"):
        evaluated(tmp_path, task, "ppo", 0.5)
    figure, _ = every_task.fifty(read(tmp_path))
    labelled = [ax.get_title(loc="left") for ax in figure.axes
                if ax.get_visible() and ax.xaxis.get_tick_params()["labelbottom"]]
    assert labelled == ["basketball", "push", "reach", "soccer", "sweep"]


def test_bars_are_sorted_and_have_the_colour_of_the_better_arm(tmp_path):
    pair(tmp_path, "push", 0.9, 0.3)
    pair(tmp_path, "reach", 0.2, 0.4)
    pair(tmp_path, "soccer", 0.5, 0.5)
    evaluated(tmp_path, "assembly", "multihead", 1.0)  # without PPO nothing to compare with
    figure, caption = every_task.fifty_difference(read(tmp_path))
    ax = figure.axes[0]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["reach", "soccer", "push"]
    assert drawn_at(ax, 0) == (RED, pytest.approx(-0.2))
    assert drawn_at(ax, 1) is None
    assert drawn_at(ax, 2) == (BLUE, pytest.approx(0.6))
    assert "3 tasks of which both" in caption and "1 tasks better, 1 worse, 1 equal" in caption


def test_tasks_that_both_solve_or_both_fail_are_told_apart(tmp_path):
    pair(tmp_path, "push", 1.0, 0.9)
    pair(tmp_path, "reach", 0.1, 0.0)
    pair(tmp_path, "soccer", 0.9, 0.5)
    ax = every_task.fifty_difference(read(tmp_path))[0].axes[0]
    marks = {ax.get_yticklabels()[int(line.get_ydata()[0])].get_text(): to_hex(line.get_markerfacecolor())
             for line in ax.lines if line.get_marker() == "o"}
    assert marks == {"push": style.GREY, "reach": "#ffffff"}


def test_where_success_is_equal_the_return_tells_the_order(tmp_path):
    for task, of_heads in (("push", 3000), ("reach", 1000)):
        evaluated(tmp_path, task, "multihead", 1.0, **{"return": of_heads})
        evaluated(tmp_path, task, "ppo", 1.0, **{"return": 2000})
    figure, _ = every_task.fifty_difference(read(tmp_path))
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["reach", "push"]
    assert drawn_at(figure.axes[1], 0) == (RED, pytest.approx(-0.2))
    assert drawn_at(figure.axes[1], 1) == (BLUE, pytest.approx(0.2))


def test_from_three_seeds_on_bars_have_intervals(tmp_path):
    for seed in (1, 2, 3):
        evaluated(tmp_path, "push", "multihead", 0.7 + 0.1 * seed, seed)
        evaluated(tmp_path, "push", "ppo", 0.1, seed)
    figure, _ = every_task.fifty_difference(read(tmp_path))
    (interval,) = [line for line in figure.axes[0].lines if line.get_color() == "black" and line.get_linewidth() == 1]
    assert 0.7 <= interval.get_xdata()[0] <= interval.get_xdata()[1] <= 0.9
    assert drawn_at(figure.axes[0], 0)[1] == pytest.approx(0.8)


def test_without_the_experiment_there_is_nothing(tmp_path):
    synthetic.cell(tmp_path, "main", "push", "multihead", 1)
    found = read(tmp_path)
    assert every_task.fifty(found) is None and every_task.fifty_difference(found) is None
    assert set(fifty.tables(found, {}).values()) == {None}


def test_one_arm_alone_has_no_difference_but_all_else(tmp_path):
    evaluated(tmp_path, "push", "ppo-time", 0.5)
    assert every_task.fifty(read(tmp_path)) and every_task.fifty_difference(read(tmp_path)) is None
    made = tables(tmp_path)
    assert "PPO + time: any" in made["fifty"] and "sign test" not in made["fifty-summary"]
    assert made["fifty-traits"] is None


def test_the_table_has_each_arm_and_the_expert(tmp_path):
    evaluated(tmp_path, "push", "multihead", 0.8, success_end=0.6, success_200=0.4, **{"return": 4000})
    evaluated(tmp_path, "push", "multihead", 1.0, 2, success_end=0.8, success_200=0.6, **{"return": 4200})
    evaluated(tmp_path, "push", "ppo", 0.5, success_200="", **{"return": 1234.4})
    evaluated(tmp_path, "reach", "ppo", 0.5, success_200="", **{"return": 4321})
    table = tables(tmp_path, {"push": experts.Expert(1.0, 0.4, 4136)})["fifty"]
    assert row_of(table, "push") == ["push", "0.90", "0.70", "0.50", "4100", "0.50", "0.50", "–", "1234", "1.00",
                                     "0.40", "4136"]
    assert row_of(table, "reach") == ["reach", *"––––", "0.50", "0.50", "–", "4321", *"–––"]
    assert "means over seeds (0 to 2 an arm)" in table


def test_without_the_program_the_table_has_no_expert_and_says_so(tmp_path):
    evaluated(tmp_path, "push", "ppo", 0.5)
    table = tables(tmp_path)["fifty"]
    assert "expert" not in table.splitlines()[0] and "was not built" in table


def test_the_summary_counts_solved_tasks_beside_published_ones(tmp_path):
    pair(tmp_path, "push", 0.9, 0.3, success_end=0.2)
    pair(tmp_path, "reach", 1.0, 0.92, success_end=0.95)
    pair(tmp_path, "soccer", 0.5, 0.1, success_200=0.0)
    table = tables(tmp_path)["fifty-summary"]
    assert row_of(table, "multi-head, k = 10")[:10] == [
        "multi-head, k = 10", "3", "1", "0.8", "0.80", "0.55", "0.63", "2", "1", "2"]
    assert row_of(table.split("\n\n")[0], "PPO")[4:10] == ["0.44", "0.42", "0.41", "1", "1", "1"]
    assert row_of(table, "BRC (published)")[1:] == ["50", "3", "1", "–", "–", "0.915", "–", "–", "41", "–"]
    assert len(published.FIFTY) == 4 and f"episodes of {published.EPISODE} steps" in table


def test_the_summary_tests_the_signs_against_each_other_arm(tmp_path):
    for task, (heads, ppo) in zip(("push", "reach", "soccer", "sweep"), ((0.9, 0.3), (1, 0.9), (0.5, 0.5), (0.2, 0.1))):
        pair(tmp_path, task, heads, ppo)
    evaluated(tmp_path, "push", "ppo-time", 1.0)
    table = tables(tmp_path)["fifty-summary"]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if " | any | " in line and "---" not in line]
    (ppo,) = [row for row in rows if row[0] == "PPO"]
    # Three of three: 2 / 2^3.
    assert ppo == ["PPO", "any", "4", "+0.20", "3", "0", "1", "0.250"]
    (seeing,) = [row for row in rows if row[0] == "PPO + time"]
    assert seeing == ["PPO + time", "any", "1", "-0.10", "0", "1", "0", "1.000"]


def test_each_task_of_the_experiment_has_its_traits():
    experiment = tomllib.loads((ROOT / "deploy" / "experiments" / "fifty.toml").read_text())
    assert sorted(traits.OF) == sorted(experiment["tasks"]) and len(traits.OF) == 50
    assert set().union(*traits.OF.values()) == set(traits.MEANING)
    # As the table's text says.
    assert all(traits.SEQUENCE in of for of in traits.OF.values() if traits.GRASP in of)


def test_traits_are_compared_with_tasks_that_lack_them(tmp_path):
    chosen = {traits.GRASP: ("assembly", "basketball", "pick-place"), "": ("reach", "dial-turn", "sweep", "door-lock")}
    for task in chosen[traits.GRASP]:
        pair(tmp_path, task, 0.9, 0.1)
    for task in chosen[""]:
        pair(tmp_path, task, 0.5, 0.5)
    table = tables(tmp_path)["fifty-traits"]
    # All of one group above all of the other: of 7 choose 3 ways to deal them out, one; twice that.
    assert row_of(table, traits.GRASP)[:7] == [traits.GRASP, "3", "4", "+0.80", "+0.00", "+0.80", "0.057"]
    assert row_of(table, traits.SEQUENCE)[1:3] == ["4", "3"]
    assert row_of(table, traits.HOLD)[1:7] == ["0", "7", "–", "+0.34", "–", "–"]
    assert traits.MEANING[traits.PRECISION] in table


@pytest.fixture(scope="module")
def scripted():
    return experts.found(BUILD / "bin" / "metronome-actor")


def test_the_program_tells_of_the_scripted_policies(scripted):
    assert sorted(scripted) == sorted(traits.OF)
    assert scripted["push"] == experts.Expert(1.0, 0.4, 4136)


def test_hold_is_what_the_scripted_policies_do(scripted):
    for task, expert in scripted.items():
        leaves = expert.success_end <= expert.success / 2
        assert (traits.HOLD in traits.OF[task]) == leaves, task


def test_another_table_of_the_program_is_refused():
    with pytest.raises(cells.ResultsError, match="prints another table.*deploy/setup"):
        experts.read("task  any  return\npush  100%  4136\n")
