"""All fifty tasks: a small panel each, and what heads give on each."""

import curves
import estimates
import names
import scores
import style
from draw import learning

EXPERIMENT = "fifty"
HEADS, BASELINE = "multihead", "ppo"
SOLVED, FAILED = 0.9, 0.1
_COLUMNS = 5
_BESIDE = 0.015  # of the axis, between the marks of two arms


def tasks_text(cells):
    count = len(names.tasks_of(cells))
    return "all fifty tasks" if count == 50 else f"{count} tasks of the fifty, those with finished runs"


def fifty(experiments):
    cells = experiments.get(EXPERIMENT, [])
    if not cells:
        return None
    tasks, arms = names.tasks_of(cells), names.arms_of(cells)
    columns, end = min(_COLUMNS, len(tasks)), max(cell.steps for cell in cells)
    figure, axes = style.grid_of_panels(-(-len(tasks) // columns), columns, width=2.2, height=1.3, sharex=True,
                                        sharey=True)
    for ax, task in zip(axes.flat, tasks):
        _panel(ax, scores.select(cells, task), arms, end)
        ax.set_title(task, loc="left", fontsize=9, pad=4)
    style.millions(axes[0, 0].xaxis, end)
    axes[0, 0].set_ylim(-0.05, 1.05)
    axes[0, 0].set_yticks([0, 0.5, 1], ["0", "", "1"])
    for ax in axes.flat[len(tasks):]:
        ax.set_visible(False)
    for ax in axes.flat[len(tasks) - columns:len(tasks)]:
        ax.tick_params(labelbottom=True)
        ax.set_xlabel("steps (millions)", fontsize=9)
    figure.supylabel("success", fontsize=10)
    style.legend(figure, style.arm_handles(cells, arms) + [
        style.grey_handle("under training noise"), style.grey_handle("mean action", marker="o", linewidth=0)])
    counts = [len(scores.select(cells, task, arm)) for task in tasks for arm in arms]
    return figure, (
        f"Share of episodes with success at any step, on {tasks_text(cells)} ({scores.seeds_text(counts)} seeds an arm "
        "and task). Lines: under training noise, trailing means over 4 % of the arm's shortest run; dots, moved aside "
        "to be seen: mean action, on 50 placements that no training run draws, at the milestones. Interquartile means "
        f"over seeds, where there are several; band: 95 % stratified bootstrap, from {estimates.FEWEST} seeds on.")


def _panel(ax, cells, arms, end):
    for i, arm in enumerate(arms):
        own, look = scores.select(cells, arm=arm), names.look_of(arm, arms)
        learning.draw_arm(ax, own, look, "success", crowded=True)
        _marks(ax, own, look, (i - (len(arms) - 1) / 2) * _BESIDE * end)


def _marks(ax, cells, look, aside):
    tables = [cell.evaluations["random"] for cell in cells if "random" in cell.evaluations]
    if tables:
        steps, values = curves.common_rows(tables, "success")
        ax.plot(steps + aside, estimates.interquartile_mean(values[:, None, :]), "o", color=look.colour, markersize=4.5,
                markeredgecolor="white", markeredgewidth=0.6, clip_on=False, zorder=4)


def differences(cells, baseline, score):
    """@return task to estimates.Difference, heads less `baseline`, of the tasks of which both have the score."""
    found = {}
    for task in names.tasks_of(cells):
        x, y = (scores.by_seed(scores.select(cells, task, arm), score) for arm in (HEADS, baseline))
        if x and y:
            found[task] = estimates.difference(x, y)
    return found


def fifty_difference(experiments):
    cells = experiments.get(EXPERIMENT, [])
    of_success, of_return = (differences(cells, BASELINE, score)
                             for score in (scores.DETERMINISTIC, scores.DETERMINISTIC_NORMALISED))
    if not of_success:
        return None
    value = {task: (found.estimate.value, of_return[task].estimate.value) for task, found in of_success.items()}
    tasks = sorted(of_success, key=lambda task: (*value[task], task))
    figure, axes = style.grid_of_panels(1, 2, width=4.3, height=1.0 + 0.19 * len(tasks), sharey=True)
    for ax, found, label in zip(axes[0], (of_success, of_return), ("success", "normalised return")):
        for y, task in enumerate(tasks):
            _bar(ax, y, found[task].estimate)
        _finish_axis(ax, f"difference of {label}")
    ends = {task: _ends(cells, task) for task in tasks}
    for y, task in enumerate(tasks):
        _mark_of_ends(axes[0, 0], y, ends[task])
    axes[0, 0].set_yticks(range(len(tasks)), tasks)
    axes[0, 0].set_ylim(-0.8, len(tasks) - 0.2)
    axes[0, 0].set_xlim(-1.12, 1.05)
    _legend(figure, cells, axes[0])
    signs = estimates.signs([found.estimate.value for found in of_success.values()])
    return figure, (
        f"Multi-head less PPO with one head, mean action at the last milestone, on {len(tasks)} tasks of which both "
        f"have finished runs; sorted by the left side. Bars have the colour of the arm that is better; left: success at "
        f"any step ({signs.better} tasks better, {signs.worse} worse, {signs.equal} equal); right: return, as a share "
        f"of the largest possible one (10 a step). Grey dots at the left edge: full, both solve the task (success "
        f"{SOLVED} or more); open, both fail (at most {FAILED}). Means over seeds; black: 95 % bootstrap interval, from "
        f"{estimates.FEWEST} seeds of each arm on.")


def _bar(ax, y, estimate):
    if estimate.value:
        better = HEADS if estimate.value > 0 else BASELINE
        ax.plot([0, estimate.value], [y, y], color=names.ARMS[better].colour, linewidth=6, solid_capstyle="butt")
    if estimate.low is not None:
        ax.plot([estimate.low, estimate.high], [y, y], color="black", linewidth=1)


def _ends(cells, task):
    """@return the scores of all runs of the two arms that are compared."""
    return [value for arm in (HEADS, BASELINE)
            for value in scores.by_seed(scores.select(cells, task, arm), scores.DETERMINISTIC).values()]


def _mark_of_ends(ax, y, ends):
    if min(ends) >= SOLVED or max(ends) <= FAILED:
        ax.plot(-1.06, y, "o", color=style.GREY, markersize=4.5,
                markerfacecolor=style.GREY if min(ends) >= SOLVED else "white")


def _finish_axis(ax, label):
    ax.axvline(0, color="black", linewidth=0.9)
    ax.set_xlabel(label)
    ax.tick_params(axis="y", length=0)


def _legend(figure, cells, axes):
    """The arms that are somewhere better, and the marks."""
    drawn = {line.get_color() for ax in axes for line in ax.lines}
    arms = [arm for arm in (HEADS, BASELINE) if names.ARMS[arm].colour in drawn]
    style.legend(figure, [style.handle(names.ARMS[arm], names.label_of(arm, cells), linewidth=6) for arm in arms] + [
        style.grey_handle("both solve", marker="o", linewidth=0),
        style.grey_handle("both fail", marker="o", linewidth=0, markerfacecolor="white")])
