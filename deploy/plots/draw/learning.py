"""Learning curves: return and success against steps or time."""

import numpy as np

import curves
import estimates
import names
import published
import scores
import style

NOISE, DETERMINISTIC = "under training noise", "deterministic policy"
MOST_WITH_SEEDS = 3  # arms; lines of single seeds of more would hide each other
BAND = (f"Thin lines, where there are at most {MOST_WITH_SEEDS} arms: single seeds. Thick: interquartile mean over "
        f"seeds (of 5 the mean of the middle 3); band: 95 % stratified bootstrap ({estimates.RESAMPLES} resamples), "
        f"drawn from {estimates.FEWEST} seeds on. ")
SMOOTHED = "Curves of training are trailing means over 4 % of the arm's shortest run. "
EVALUATED = "Deterministic: mean action, on placements that no training run draws, at the milestones. "
COUNTS = "n: seeds of each arm, in the legend's order."


def _tables(cells, source):
    if source == NOISE:
        return [cell.progress for cell in cells]
    return [cell.evaluations["random"] for cell in cells if "random" in cell.evaluations]


def _with_minutes(tables):
    return [{**table, "minutes": table["wall_seconds"] / 60} for table in tables]


def draw_arm(ax, cells, look, column, source=NOISE, x="steps", crowded=False):
    """Interquartile mean and band of one arm; its seeds one by one, unless the panel is `crowded`.
    @return how many there are."""
    tables = _tables(cells, source)
    if not tables:
        return 0
    if x == "minutes":
        tables = _with_minutes(tables)
    marker = "" if source == NOISE else "o"
    if source == NOISE:
        grid, values = curves.smooth(tables, column, x)
    else:
        grid, values = curves.common_rows(tables, column)
    style_of_line = {"color": look.colour, "linestyle": look.line, "marker": marker, "markersize": 3.2}
    for row in values if not crowded or len(values) < estimates.FEWEST else []:
        ax.plot(grid, row, **{**style_of_line, "marker": ""}, linewidth=0.7, alpha=0.4)
    mean, low, high = estimates.band(values)
    if low is not None:
        ax.fill_between(grid, low, high, color=look.colour, alpha=0.08 if crowded else 0.17, linewidth=0)
    ax.plot(grid, mean, **style_of_line, linewidth=2.0)
    return len(tables)


def _finish_axis(ax, column, end):
    if column == "return":
        ax.set_ylim(bottom=0)
        style.thousands(ax.yaxis)
    else:
        ax.set_ylim(-0.03, 1.03)
    style.millions(ax.xaxis, end)


def _panel(ax, cells, arms, column, source):
    counts = [draw_arm(ax, scores.select(cells, arm=arm), names.look_of(arm, arms), column, source,
                       crowded=len(arms) > MOST_WITH_SEEDS) for arm in arms]
    style.note(ax, "n = " + ", ".join(str(count) if count else "–" for count in counts))
    if not any(counts):
        style.nothing_yet(ax)
    _finish_axis(ax, column, max(cell.steps for cell in cells))


def curves_figure(cells, rows, arms=None, finish=lambda ax, task, row: None):
    """@param rows  (column, source, label of the y axis) each.
    @param finish  called for each panel, with the row's index."""
    arms = [arm for arm in names.arms_of(cells) if arms is None or arm in arms]
    cells = [cell for cell in cells if cell.arm in arms]
    tasks = names.tasks_of(cells)
    if not tasks:
        return None
    figure, axes = style.grid_of_panels(len(rows), len(tasks))
    for i, (column, source, label) in enumerate(rows):
        for j, task in enumerate(tasks):
            ax = axes[i, j]
            _panel(ax, scores.select(cells, task), arms, column, source)
            if i == 0:
                ax.set_title(task, loc="left")
            if j == 0:
                ax.set_ylabel(label)
            if i == len(rows) - 1:
                ax.set_xlabel("environment steps (millions)")
            finish(ax, task, i)
    handles = style.arm_handles(cells, arms)
    return figure, handles


def _with_legend(made, caption):
    if made is None:
        return None
    figure, handles = made
    style.legend(figure, handles)
    return figure, caption


RETURN_ROW = ("return", NOISE, "average return")
SUCCESS_ROWS = (("success", NOISE, "success, " + NOISE), ("success", DETERMINISTIC, "success, deterministic"))


def main(experiments):
    made = curves_figure(experiments.get("main", []), [RETURN_ROW])
    return _with_legend(made, "Average return against environment steps (of 5000, 10 a step). "
                        + BAND + SMOOTHED + COUNTS)


def main_success(experiments):
    made = curves_figure(experiments.get("main", []), SUCCESS_ROWS)
    return _with_legend(made, "Share of episodes with success at any step. " + BAND + SMOOTHED
                        + EVALUATED + COUNTS)


def ablation(experiments):
    cells = experiments.get("main", [])
    if not scores.select(cells, arm="ppo-time"):
        return None
    made = curves_figure(cells, [RETURN_ROW], arms=("multihead", "ppo-time"))
    return _with_legend(made, "Time as an index of heads against time in the observation: average return. "
                        "The paper shows two tasks, this all four. " + BAND + SMOOTHED + COUNTS)


def every_curve(experiments, name):
    """For experiments that have no figure of their own kind; beside them main's multi-head, where they
    have none themselves and their runs are as long."""
    cells = experiments[name]
    tasks, lengths = names.tasks_of(cells), {cell.steps for cell in cells}
    compared = [] if scores.select(cells, arm="multihead") else [
        cell for cell in scores.select(experiments.get("main", []), arm="multihead")
        if cell.task in tasks and cell.steps in lengths]
    made = curves_figure(cells + compared, [RETURN_ROW, *SUCCESS_ROWS])
    return _with_legend(made, f"Experiment {name}: return and success against environment steps. "
                        + ("Multi-head is that of experiment main. " if compared else "")
                        + BAND + SMOOTHED + EVALUATED + COUNTS)


def published_marks(ax, task, end):
    """@return the handles of what was drawn."""
    drawn = []
    if task not in published.SAC or end < published.STEPS:
        return drawn
    for name, marker, value in (("SAC, 2 M steps (published)", "X", published.SAC[task]),
                                ("TD-MPC2, 2 M steps (published)", "P", published.TD_MPC2[task])):
        (mark,) = ax.plot(published.STEPS, value, marker, color="white", markeredgecolor="black",
                          markersize=8, clip_on=False, zorder=6, label=name)
        drawn.append(mark)
    return drawn


def solve(experiments):
    cells = experiments.get("solve", [])
    marks = []

    def finish(ax, task, row):
        ax.axhline(0.9, color="black", linewidth=0.9, linestyle=(0, (4, 3)))
        if row == 1:
            end = max(cell.steps for cell in scores.select(cells, task))
            marks.append(published_marks(ax, task, end))

    made = curves_figure(cells, SUCCESS_ROWS, finish=finish)
    if made is None:
        return None
    figure, handles = made
    style.legend(figure, handles + max(marks, key=len, default=[]))
    return figure, ("Configurations that solve the tasks: share of episodes with success at any step; "
                    "dashed: 0.9. " + BAND + SMOOTHED + EVALUATED + COUNTS)


def wallclock(experiments):
    cells = experiments.get("main", [])
    tasks, arms = names.tasks_of(cells), names.arms_of(cells)
    if not tasks:
        return None
    figure, axes = style.grid_of_panels(1, len(tasks))
    for ax, task in zip(axes[0], tasks):
        counts = [draw_arm(ax, scores.select(cells, task, arm), names.look_of(arm, arms), "success",
                           x="minutes", crowded=len(arms) > MOST_WITH_SEEDS) for arm in arms]
        style.note(ax, "n = " + ", ".join(str(count) if count else "–" for count in counts))
        ax.set_title(task, loc="left")
        ax.set_ylim(-0.03, 1.03)
        end = max(line.get_xdata()[-1] for line in ax.lines)
        ax.set_xlim(0, np.nextafter(end, np.inf))
        ax.set_xlabel("wall-clock time (minutes)")
    axes[0, 0].set_ylabel("success, " + NOISE)
    style.legend(figure, style.arm_handles(cells, arms))
    return figure, ("Success under training noise against wall-clock time of the run. Runs shared a machine "
                    "of 2 cores with other runs: times are upper bounds and scatter. " + BAND
                    + "A mean ends with the arm's shortest run, a panel with its longest mean. " + SMOOTHED + COUNTS)
