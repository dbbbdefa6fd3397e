"""The end of training: every arm on every task, and over all tasks."""

import numpy as np

import estimates
import names
import scores
import style

BASELINES = ("ppo", "ppo-time")


def dot(ax, x, estimate, look, upright=True, **options):
    """A point estimate with its interval; an open one where there is no interval."""
    options = {"color": look.colour, "marker": "o", "markersize": 6, **options}
    if estimate.low is None:
        xy = (x, estimate.value) if upright else (estimate.value, x)
        ax.plot(*xy, **{**options, "linestyle": "", "markerfacecolor": "white"})
        return
    ends = [[max(0.0, estimate.value - estimate.low)], [max(0.0, estimate.high - estimate.value)]]
    if upright:
        ax.errorbar(x, estimate.value, yerr=ends, linestyle="", elinewidth=2, capsize=0, **options)
    else:
        ax.errorbar(estimate.value, x, xerr=ends, linestyle="", elinewidth=2, capsize=0, **options)


def _by_task_panel(ax, cells, tasks, arms, score):
    shared = scores.shared_tasks(cells, tasks, arms, score)
    groups = [(task, [task]) for task in tasks] + ([(f"{len(shared)} tasks", shared)] if len(shared) > 1 else [])
    step = 0.6 / max(1, len(arms))
    for i, (_, members) in enumerate(groups):
        for j, arm in enumerate(arms):
            found = scores.by_task(cells, arm, members, score)
            if all(found):
                x = i + (j - (len(arms) - 1) / 2) * step
                for values in found if len(members) == 1 else []:
                    ax.plot([x + step / 3.2] * len(values), values, ".", markersize=3.5, alpha=0.5,
                            color=names.look_of(arm, arms).colour)
                dot(ax, x, estimates.iqm(found), names.look_of(arm, arms))
    if len(groups) > len(tasks):
        ax.axvline(len(tasks) - 0.5, color=style.GREY, linewidth=0.8)
    if not scores.by_seed(cells, score):
        style.nothing_yet(ax)
    ax.set_xlim(-0.5, len(groups) - 0.5)
    ax.set_xticks(range(len(groups)), [name.replace(" ", "\n").replace("-", "-\n") for name, _ in groups])
    ax.grid(visible=False, axis="x")
    ax.set_title(score.label, loc="left")
    if score.share:
        ax.set_ylim(-0.03, 1.03)
    else:
        ax.set_ylim(bottom=0)
        style.thousands(ax.yaxis)


def _improvement_panel(ax, cells, tasks, arms):
    rows = []
    for score in scores.COMPARED:
        for arm in [arm for arm in BASELINES if arm in arms]:
            shared = scores.shared_tasks(cells, tasks, ("multihead", arm), score)
            if shared:
                rows.append((score, arm, estimates.probability_of_improvement(
                    *(scores.by_task(cells, name, shared, score) for name in ("multihead", arm)))))
    places = {}
    for i, (score, arm, estimate) in enumerate(rows):
        dot(ax, -i, estimate, names.look_of(arm, arms), upright=False)
        places.setdefault(score.label.replace(" ", "\n"), []).append(-i)
    ax.axvline(0.5, color="black", linewidth=0.9, linestyle=(0, (4, 3)))
    ax.set_yticks([np.mean(rows_of) for rows_of in places.values()], list(places))
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(-len(rows) + 0.4, 0.6)
    ax.set_xlim(-0.03, 1.03)
    ax.grid(visible=False, axis="y")
    ax.set_title("P(multi-head scores higher)", loc="left")
    ax.set_xlabel("probability of improvement over the colour's arm")


def _profile_panel(ax, cells, tasks, arms, score):
    thresholds = np.linspace(0, 1, 101)
    shared = scores.shared_tasks(cells, tasks, arms, score)
    for arm in arms if shared else []:
        look = names.look_of(arm, arms)
        share, low, high = estimates.profile(scores.by_task(cells, arm, shared, score), thresholds)
        if low is not None:
            ax.fill_between(thresholds, low, high, color=look.colour, alpha=0.17, linewidth=0)
        ax.plot(thresholds, share, color=look.colour, linestyle=look.line, linewidth=2)
    ax.set_title(f"profile: {score.label}", loc="left")
    ax.set_xlabel(f"threshold on {score.label.replace('normalised return', 'return / 5000')}")
    ax.set_ylabel("share of runs above it")
    ax.set_xlim(0, 1)
    ax.set_ylim(-0.03, 1.03)


def final(experiments):
    cells = experiments.get("main", [])
    if not cells:
        return None
    tasks, arms = names.tasks_of(cells), names.arms_of(cells)
    figure, axes = style.grid_of_panels(2, 3, width=4.3, height=3.0)
    for ax, score in zip(axes[0], scores.COMPARED):
        _by_task_panel(ax, cells, tasks, arms, score)
    _improvement_panel(axes[1, 0], cells, tasks, arms)
    _profile_panel(axes[1, 1], cells, tasks, arms, scores.NORMALISED)
    _profile_panel(axes[1, 2], cells, tasks, arms, scores.SUCCESS)
    style.legend(figure, style.arm_handles(cells, arms))
    counts = [len(scores.select(cells, task, arm)) for task in tasks for arm in arms]
    return figure, (
        f"The end of training ({scores.seeds_text(counts)} seeds an arm and task). Under noise: mean of the "
        "last 10 updates of a run; deterministic: its last evaluation. Above: interquartile means over seeds "
        "(small dots), over tasks and seeds at the right; below: probability that a run of multi-head scores "
        "higher than one of the other arm on the same task (ties half), and performance profiles, over the "
        f"tasks of which every arm compared has at least {estimates.FEWEST} seeds (or any, where no task has so "
        "many). Returns over tasks are divided by the largest possible one, 10 a step "
        f"(5000). Intervals: 95 % stratified bootstrap, {estimates.RESAMPLES} resamples, rliable; open dots: "
        f"fewer than {estimates.FEWEST} seeds, no interval.")
