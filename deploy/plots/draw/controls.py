"""What else might explain the gain of heads: every control against the arm that it controls for."""

import estimates
import names
import scores
import style
from draw.final import dot

SHOWN = (scores.RETURN, scores.SUCCESS, scores.DETERMINISTIC)


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


def controls(experiments):
    rows = pairs(experiments)
    if not rows:
        return None
    arms = names.in_order({arm for arm, *_ in rows}, names.ARMS)
    tasks = names.in_order({task for _, _, task, *_ in rows}, names.TASKS)
    figure, axes = style.grid_of_panels(1, len(SHOWN), width=4.0, height=0.42 + 0.21 * (len(rows) + len(arms)),
                                        sharey=True)
    places, labels, y = [], [], 0.0
    for arm in arms:
        labels.append((y, arm, next(reference for name, reference, *_ in rows if name == arm)))
        for task in tasks:
            for name, _, where, cells, reference in rows:
                if (name, where) == (arm, task):
                    y -= 1
                    places.append((y, task))
                    for ax, score in zip(axes[0], SHOWN):
                        _mark(ax, y, names.look_of(arm, arms), cells, reference, score)
        y -= 1.4
    for ax, score in zip(axes[0], SHOWN):
        ax.axvline(0, color="black", linewidth=0.9)
        ax.set_xlabel(f"difference of {score.label}")
        ax.grid(visible=False, axis="y")
        ax.tick_params(axis="y", length=0)
    ax = axes[0, 0]
    ax.set_yticks([*(at for at, _ in places), *(at for at, *_ in labels)],
                  [*(task for _, task in places), *(_title(arm, reference, arms) for _, arm, reference in labels)])
    for text in ax.get_yticklabels()[len(places):]:
        text.set_fontweight("bold")
    ax.set_ylim(y + 0.8, 0.8)
    counts = [len(group) for *_, cells, reference in rows for group in (cells, reference)]
    return figure, (
        f"Controls less the multi-head policy that they control for, at the end of training "
        f"({scores.seeds_text(counts)} seeds an arm and task); left of 0: the control is worse. Differences of "
        f"means with 95 % percentile bootstrap intervals ({estimates.RESAMPLES} resamples), paired by seed where "
        f"{estimates.FEWEST} or more seeds are common; open dots: too few seeds for an interval.")


def _title(arm, reference, arms):
    label = names.look_of(arm, arms).label
    return label if reference == "multihead" else f"{label}\n(against {names.look_of(reference, [reference]).label})"


def _mark(ax, y, look, cells, reference, score):
    x, base = scores.by_seed(cells, score), scores.by_seed(reference, score)
    if x and base:
        dot(ax, y, estimates.difference(x, base).estimate, look, upright=False)
