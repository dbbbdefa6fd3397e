"""The comparisons that are drawn, and that figures come from the data that is there."""

import importlib.util
import itertools
import tomllib

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb

import cells
import estimates
import fifty
import names
import scores
import style
import synthetic
import tables
from conftest import ROOT
from draw import controls, efficiency, every_task, final, heads, learning


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    """How good intervals are is tested elsewhere."""
    monkeypatch.setattr(estimates, "RESAMPLES", 20)
    yield
    plt.close("all")


def read(folder):
    return cells.read_results(folder)[0]


def test_k_equal_to_one_and_ten_come_from_main_where_lengths_agree(tmp_path):
    synthetic.main_experiment(tmp_path, seeds=2, tasks=["push"], updates=40)
    synthetic.cell(tmp_path, "heads", "push", "k2", 1, heads=2, updates=40)
    found = heads.sweep(read(tmp_path), "push")
    assert {k: (len(own), borrowed) for k, (own, borrowed) in found.items()} == {
        1: (2, True), 2: (1, False), 10: (2, True)}


def test_runs_of_other_length_do_not_enter_the_sweep(tmp_path):
    synthetic.main_experiment(tmp_path, seeds=1, tasks=["push"], updates=60)
    synthetic.cell(tmp_path, "heads", "push", "k2", 1, heads=2, updates=40)
    assert list(heads.sweep(read(tmp_path), "push")) == [2]


def test_a_control_is_compared_with_multihead_of_its_own_horizon(tmp_path):
    synthetic.cell(tmp_path, "main", "push", "multihead", 1)
    synthetic.cell(tmp_path, "controls", "push", "shuffled", 1)
    synthetic.cell(tmp_path, "controls", "push", "t100-k20", 1, heads=20, horizon=100)
    synthetic.cell(tmp_path, "controls", "push", "t100-ppo", 1, method="ppo", heads=1, horizon=100)
    synthetic.cell(tmp_path, "controls", "push", "short", 1, updates=20)
    found = {arm: reference for arm, reference, *_ in controls.pairs(read(tmp_path))}
    assert found == {"shuffled": "multihead", "t100-ppo": "t100-k20"}


def test_an_experiment_with_its_own_multihead_is_compared_with_that(tmp_path):
    for experiment in ("main", "controls"):
        synthetic.cell(tmp_path, experiment, "push", "multihead", 1)
    synthetic.cell(tmp_path, "controls", "push", "shuffled", 1)
    (pair,) = controls.pairs(read(tmp_path))
    assert [cell.experiment for cell in pair[4]] == ["controls"]


def test_only_tasks_with_enough_seeds_of_all_arms_are_averaged(tmp_path):
    for seed in (1, 2, 3):
        for task in ("push", "assembly"):
            synthetic.cell(tmp_path, "main", task, "multihead", seed)
        synthetic.cell(tmp_path, "main", "push", "ppo", seed)
    synthetic.cell(tmp_path, "main", "assembly", "ppo", 1)
    found = read(tmp_path)["main"]
    shared = scores.shared_tasks(found, ["assembly", "push"], ["multihead", "ppo"], scores.RETURN)
    assert shared == ["push"]


def test_a_normalised_return_is_of_ten_a_step(tmp_path):
    synthetic.cell(tmp_path, "e", "push", "multihead", 1, horizon=100)
    (cell,) = read(tmp_path)["e"]
    assert scores.NORMALISED.of(cell) == pytest.approx(cell.progress["return"][-10:].mean() / 1000)


def test_seeds_that_never_succeed_count_as_later(tmp_path):
    for seed, level in ((1, 0.97), (2, 0.02), (3, 0.02)):
        synthetic.cell(tmp_path, "main", "push", "multihead", seed, level=level)
    found = efficiency.reaches(read(tmp_path)["main"], learning.DETERMINISTIC, 0.5)
    assert np.isfinite(found).tolist() == [True, False, False]
    assert "later (1 of 3)" in tables.reach(read(tmp_path))


def test_unknown_arms_get_looks_that_nobody_else_has():
    arms = ["interleaved", "bootstrap", *(f"new-{i}" for i in range(20))]
    looks = [names.look_of(arm, arms) for arm in arms]
    assert len({(look.colour, look.line) for look in looks}) == len(arms)
    assert not {look.colour for look in looks[2:]} & {look.colour for look in names.ARMS.values()}


def every_arm(results):
    """All arms of the committed experiments, on one task."""
    for path in sorted((ROOT / "deploy" / "experiments").glob("*.toml")):
        experiment = tomllib.loads(path.read_text())
        for arm, settings in experiment["arms"].items():
            method = settings.get("method", "multihead")
            synthetic.cell(results, experiment["name"], "push", arm, 1, method=method,
                           heads=settings.get("heads", 1), horizon=settings.get("horizon", 500), updates=20)
    return read(results)


def all_figures(experiments):
    """Name to figure, of all that deploy/figures draws of runs."""
    spec = importlib.util.spec_from_file_location("command", ROOT / "deploy" / "plots" / "__main__.py")
    command = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(command)
    made = {name: draw(experiments) for name, draw in command.drawings(experiments, {}).items()}
    return {name: figure for name, (figure, _) in ((name, each) for name, each in made.items() if each)}


def is_arm(colour):
    """Black, white and greys are no arm's."""
    return np.ptp(to_rgb(colour)) > 0.01


def colours_in(ax):
    """Hex to the heights at which it is drawn."""
    found = {}
    for line in ax.lines:
        if is_arm(line.get_color()):
            found.setdefault(to_hex(line.get_color()), set()).update(np.atleast_1d(line.get_ydata()))
    return found


def arms_in(figure):
    """Label to colour: by the legend, or where the rows have titles by these."""
    if figure.legends:
        (legend,) = figure.legends
        colours = {text.get_text(): to_hex(line.get_color())
                   for text, line in zip(legend.get_texts(), legend.legend_handles)}
        colours = {label: colour for label, colour in colours.items() if is_arm(colour)}
        assert set().union(*map(colours_in, figure.axes)) == set(colours.values())
        return colours
    rows = {y: text for y, text in zip(figure.axes[0].get_yticks(), figure.axes[0].get_yticklabels())}
    titles = {y: text.get_text().split("\n")[0] for y, text in rows.items() if text.get_fontweight() == "bold"}
    return {titles[min(above for above in titles if above > y)]: colour
            for colour, heights in colours_in(figure.axes[0]).items() for y in heights if y in rows}


@pytest.fixture(scope="module")
def committed(tmp_path_factory):
    """(the arms of the committed experiments, name of each figure to label to colour)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(estimates, "RESAMPLES", 20)
        experiments = every_arm(tmp_path_factory.mktemp("results"))
        figures = {name: arms_in(figure) for name, figure in all_figures(experiments).items()}
        return {cell.arm for found in experiments.values() for cell in found}, figures


def test_an_arm_has_one_colour_in_all_figures_and_no_other_arm_has_it(committed):
    arms, figures = committed
    colours = {}
    for name, drawn in figures.items():
        for label, colour in drawn.items():
            assert colours.setdefault(label, colour) == colour, f"{label} in {name}"
    assert len(set(colours.values())) == len(colours), colours
    assert len(colours) == len(arms), "an arm has two labels, or two arms have one"


# Deuteranopia and protanopia (Machado, Oliveira, Fernandes 2009), on linear RGB.
SEEN = {"by all": np.eye(3),
        "without green": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
        "without red": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]])}
TO_XYZ = np.array([[0.4339, 0.3762, 0.1899], [0.2127, 0.7152, 0.0722], [0.0178, 0.1095, 0.8727]])  # white is 1, 1, 1


def cielab(colour, seen):
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(seen @ linear, 0, 1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("seen", SEEN)
def test_colours_that_meet_in_a_figure_can_be_told_apart(committed, seen):
    for name, drawn in committed[1].items():
        for one, other in itertools.combinations(drawn, 2):
            distance = np.linalg.norm(cielab(drawn[one], SEEN[seen]) - cielab(drawn[other], SEEN[seen]))
            assert distance > 15, f"{one} and {other} in {name}"  # 2.3 is the least that is seen at all


def test_k_equal_to_one_and_ten_are_ppo_and_multihead(tmp_path):
    figure = all_figures(every_arm(tmp_path))["heads"]
    colours = {line.get_xdata()[0]: to_hex(line.get_color()) for line in figure.axes[0].lines
               if len(line.get_xdata()) == 1 and line.get_marker() == "o"}
    assert (colours[1], colours[10]) == (names.ARMS["ppo"].colour.lower(), names.ARMS["multihead"].colour.lower())


def test_known_names_come_first():
    assert names.in_order({"zebra", "ppo", "multihead", "door"}, names.ARMS) == [
        "multihead", "ppo", "door", "zebra"]


def test_wall_clock_panels_end_with_the_longest_curve(tmp_path):
    """Not with the longest run: an arm's mean ends with its shortest."""
    for seed, steps_per_update in ((1, 9000), (2, 90000)):
        synthetic.cell(tmp_path, "main", "push", "multihead", seed, steps_per_update=steps_per_update)
        synthetic.cell(tmp_path, "main", "push", "ppo", seed, steps_per_update=2 * steps_per_update)
    figure, _ = learning.wallclock(read(tmp_path))
    ends = [max(line.get_xdata()) for line in figure.axes[0].lines]
    assert figure.axes[0].get_xlim()[1] == pytest.approx(max(ends)) and max(ends) < 3


def test_every_figure_and_table_can_be_made_of_one_run_without_evaluation(tmp_path):
    for experiment in ("main", "heads", "controls", "solve", "fifty"):
        synthetic.cell(tmp_path, experiment, "push", "multihead", 1, evaluations=0, updates=3)
    experiments = read(tmp_path)
    for draw in (learning.main, learning.main_success, learning.wallclock, learning.solve, final.final,
                 heads.heads, efficiency.efficiency, every_task.fifty):
        style.use()
        figure, caption = draw(experiments)
        style.save(figure, tmp_path / "figure.png")
        assert caption.strip().endswith(".")
    made = [table(experiments) for table in tables.TABLES.values()] + [*fifty.tables(experiments, {}).values()]
    assert all("nan" not in (table or "") for table in made)


def test_a_table_says_where_seeds_are_too_few(tmp_path):
    for seed in (1, 2):
        synthetic.cell(tmp_path, "main", "push", "multihead", seed)
    assert "too few" in tables.final(read(tmp_path)).splitlines()[2]


def test_a_table_of_differences_says_the_smallest_p_of_its_own_seeds(tmp_path):
    for task, seeds in (("push", (1, 2, 3)), ("assembly", (1, 2, 3, 4, 5)), ("box-close", (1, 2))):
        for seed in seeds:
            synthetic.cell(tmp_path, "main", task, "multihead", seed)
            synthetic.cell(tmp_path, "main", task, "ppo", seed, method="ppo", heads=1)
            if task == "push":
                synthetic.cell(tmp_path, "controls", task, "shuffled", seed)
    found = read(tmp_path)
    assert "smallest possible is 0.100 with 3 and 3 seeds, 0.008 with 5 and 5. " in tables.differences(found)
    assert "smallest possible is 0.100 with 3 and 3 seeds. " in tables.control_differences(found)


def test_a_table_without_tests_tells_of_none(tmp_path):
    for arm in ("multihead", "ppo"):
        synthetic.cell(tmp_path, "main", "push", arm, 1)
    assert "permutation" not in tables.differences(read(tmp_path))


def test_the_table_of_heads_tells_the_trend_over_all_runs(tmp_path):
    for seed in (1, 2, 3):
        synthetic.cell(tmp_path, "heads", "push", "k2", seed, heads=2, level=0.2)
        synthetic.cell(tmp_path, "main", "push", "multihead", seed, level=0.9)
    trend = tables.head_sweep(read(tmp_path)).splitlines()[4].split(" | ")
    assert trend[:4] == ["| push", "trend", "–", "6"], trend
    # All of one level below all of the other: of 6! / 3!^2 ways to deal them out, one, and its reverse.
    assert trend[4] == "+0.88 (p = 0.100)", trend


def test_evaluations_on_other_placements_are_kept_apart(tmp_path):
    path = synthetic.cell(tmp_path, "main", "push", "multihead", 1).evaluations_path
    rows = path.read_text().splitlines()
    path.write_text("\n".join([rows[0], *(row.replace("random", place) for row in rows[1:]
                                          for place in ("mt1", "random"))]) + "\n")
    (cell,) = read(tmp_path)["main"]
    assert sorted(cell.evaluations) == ["mt1", "random"]
    assert len(cell.evaluations["random"]["steps"]) == 4
