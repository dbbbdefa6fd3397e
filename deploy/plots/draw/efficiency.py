"""Sample efficiency: how many steps success takes."""

import numpy as np

import curves
import names
import scores
import style
from draw import learning

THRESHOLDS = (0.5, 0.8, 0.9)


def reach(cell, source, threshold):
    """Steps until success is `threshold` or more: under noise as a mean over 10 updates; of the
    deterministic policy at a milestone.  @return None if it never is."""
    if source == learning.NOISE:
        values = curves.noise_average(cell.progress["success"])
        return curves.first_reach(cell.progress["steps"], values, threshold)
    table = cell.evaluations.get("random")
    return curves.first_reach(table["steps"], table["success"], threshold) if table else None


def reaches(cells, source, threshold):
    """Steps, one each run that has such a source; infinite where it never reached."""
    counted = [cell for cell in cells if source == learning.NOISE or "random" in cell.evaluations]
    found = (reach(cell, source, threshold) for cell in counted)
    return np.array([np.inf if steps is None else steps for steps in found])


def efficiency(experiments):
    cells = experiments.get("main", [])
    tasks, arms = names.tasks_of(cells), names.arms_of(cells)
    if not tasks:
        return None
    figure, axes = style.grid_of_panels(3, len(tasks), sharex="col")
    marks = []
    for j, task in enumerate(tasks):
        own = scores.select(cells, task)
        end = max(cell.steps for cell in own)
        counts = [learning.draw_arm(axes[0, j], scores.select(own, arm=arm), names.look_of(arm, arms),
                                    "success", learning.DETERMINISTIC,
                                    crowded=len(arms) > learning.MOST_WITH_SEEDS) for arm in arms]
        style.note(axes[0, j], "n = " + ", ".join(map(str, counts)))
        if not any(counts):
            style.nothing_yet(axes[0, j])
            style.nothing_yet(axes[1, j])
        axes[0, j].set_title(task, loc="left")
        axes[0, j].set_ylim(-0.03, 1.03)
        marks.append(learning.published_marks(axes[0, j], task, end))
        for ax, source in zip(axes[1:, j], (learning.DETERMINISTIC, learning.NOISE)):
            _reach_panel(ax, own, arms, source, end)
        style.millions(axes[-1, j].xaxis, end)
        axes[-1, j].set_xlabel("environment steps (millions)")
    axes[0, 0].set_ylabel("success, deterministic")
    axes[1, 0].set_ylabel("steps until success,\ndeterministic")
    axes[2, 0].set_ylabel("steps until success,\nunder training noise")
    style.legend(figure, style.arm_handles(cells, arms) + max(marks, key=len))
    return figure, (
        "Sample efficiency. Above: success of the deterministic policy, with published results at 2 M steps "
        "(means of 3 seeds). Below: steps until success first is 0.5, 0.8, 0.9: of the deterministic policy "
        "at a milestone, under noise as a mean over 10 updates. Dots: seeds; bars: medians over all seeds, those "
        "that never got there counted as later; at the right: how many of the seeds did. " + learning.BAND)


def _reach_panel(ax, cells, arms, source, end):
    step = 0.7 / max(1, len(arms))
    for i, threshold in enumerate(THRESHOLDS):
        for j, arm in enumerate(arms):
            found = reaches(scores.select(cells, arm=arm), source, threshold)
            if not len(found):
                continue
            y, colour = -i - (j - (len(arms) - 1) / 2) * step, names.look_of(arm, arms).colour
            reached = found[np.isfinite(found)]
            ax.plot(reached, [y] * len(reached), "o", markersize=3.5, color=colour, alpha=0.6)
            middle = np.median(found)
            if np.isfinite(middle):
                ax.plot([middle] * 2, [y - step / 2.4, y + step / 2.4], color=colour, linewidth=2.4)
            ax.text(1.01, y, f"{len(reached)}/{len(found)}", transform=ax.get_yaxis_transform(),
                    va="center", fontsize=7.5, color=colour)
    ax.set_yticks([-i for i in range(len(THRESHOLDS))], [f"{threshold:g}" for threshold in THRESHOLDS])
    ax.set_ylim(-len(THRESHOLDS) + 0.5, 0.5)
    for i in range(1, len(THRESHOLDS)):
        ax.axhline(0.5 - i, color="#E4E4E4", linewidth=0.6)
    ax.grid(visible=False, axis="y")
    ax.set_xlim(0, end)
