"""Other explanations for the gain of heads: every control against the arm that it controls for."""

from matplotlib.ticker import MaxNLocator

import estimates
import names
import scores
import style
from draw.final import dot



def _reference(cell, pool):
    """The arm to compare with: multi-head of the same horizon and length on that task."""
    fitting = [other for other in pool
               if other.method == "multihead" and other.task == cell.task
               and other.horizon == cell.horizon and other.steps == cell.steps]
    arms = {other.arm for other in fitting}
    if "multihead" in arms:
        return "multihead"
    return names.in_order(arms, names.ARMS)[0] if arms else None


def pairs(experiments):
    """@return (arm, reference, task, the arm's cells, the reference's cells) each. The reference is the
    experiment's own, or where it has none main's."""
    own = experiments.get("controls", [])
    lacking = [cell for cell in experiments.get("main", [])
               if cell.arm == "multihead" and not scores.select(own, cell.task, "multihead")]
    pool, found = own + lacking, []
    for arm in names.arms_of(own):
        for task in names.tasks_of(own):
            cells = scores.select(own, task, arm)
            reference = _reference(cells[0], pool) if cells else None
            if reference and reference != arm:
                found.append((arm, reference, task, cells, scores.select(pool, task, reference)))
    return found


def pooled(rows, score):
    """@param rows  those of one arm.  @return as estimates.pooled_difference."""
    x, y = ([scores.by_seed(row[column], score) for row in rows] for column in (3, 4))
    return estimates.pooled_difference(x, y)


def controls(experiments):
    rows = pairs(experiments)
    if not rows:
        return None
    arms = names.in_order({arm for arm, *_ in rows}, names.ARMS)
    height = 0.42 + 0.2 * (len(rows) + 2.7 * len(arms))
    figure, axes = style.grid_of_panels(1, len(scores.COMPARED), width=3.9, height=height, sharey=True)
    labels, titles, y = {}, {}, 0.0
    for arm in arms:
        own = [row for row in rows if row[0] == arm]
        _, reference, _, cells, against = own[0]
        title = names.label_of(arm, cells)
        if reference != "multihead":
            title += f"\nless {names.label_of(reference, against)}"
        titles[y - 0.4 * title.count("\n")] = title
        y -= 0.8 * title.count("\n")
        for _, _, task, cells, against in own:
            y -= 1
            labels[y] = task
            for ax, score in zip(axes[0], scores.COMPARED):
                _mark(ax, y, names.look_of(arm, arms), cells, against, score)
        y -= 1
        for ax, score in zip(axes[0], scores.COMPARED):
            found = pooled(own, score)
            if found:
                labels[y] = f"{found[1]} tasks"
                dot(ax, y, found[0], names.look_of(arm, arms), upright=False, marker="D")
        y -= 1.5
    for ax, score in zip(axes[0], scores.COMPARED):
        _finish_axis(ax, score)
    _label_rows(axes[0, 0], labels, titles)
    axes[0, 0].set_ylim(y + 0.9, 0.8)
    counts = [len(group) for *_, cells, against in rows for group in (cells, against)]
    return figure, (
        f"Controls less the multi-head policy that they control for, at the end of training "
        f"({scores.seeds_text(counts)} seeds an arm and task); left of 0: the control is worse. Differences of "
        f"means with 95 % percentile bootstrap intervals ({estimates.RESAMPLES} resamples), paired by seed where "
        f"{estimates.FEWEST} or more seeds are common; diamonds: mean over the tasks, pairs resampled within each; "
        "open: too few seeds for an interval.")


def _finish_axis(ax, score):
    ax.axvline(0, color="black", linewidth=0.9)
    ax.set_xlabel(f"difference of {score.label}")
    ax.grid(visible=False, axis="y")
    ax.tick_params(axis="y", length=0)
    ax.xaxis.set_major_locator(MaxNLocator(5))
    if not score.share:
        style.thousands(ax.xaxis)


def _label_rows(ax, labels, titles):
    ax.set_yticks([*labels, *titles], [*labels.values(), *titles.values()])
    for text in ax.get_yticklabels()[len(labels):]:
        text.set_fontweight("bold")


def _mark(ax, y, look, cells, against, score):
    x, base = scores.by_seed(cells, score), scores.by_seed(against, score)
    if x and base:
        dot(ax, y, estimates.difference(x, base).estimate, look, upright=False)
