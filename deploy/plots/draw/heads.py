"""How many heads: the sweep over k."""

import estimates
import names
import scores
import style
from draw.final import dot



def sweep(experiments, task):
    """@return k to (cells, whether they are experiment main's). Experiment heads, and where it lacks a k,
    that of main: PPO is k = 1. Only runs of as many steps as the sweep's own."""
    own = scores.select(experiments.get("heads", []), task)
    found = {}
    for cell in own:
        found.setdefault(cell.heads, ([], False))[0].append(cell)
    lengths = {cell.steps for cell in own}
    borrowed = {}
    for cell in scores.select(experiments.get("main", []), task):
        if cell.method in ("single", "ppo", "multihead") and cell.steps in lengths and cell.heads not in found:
            borrowed.setdefault(cell.heads, ([], True))[0].append(cell)
    return dict(sorted({**found, **borrowed}.items()))


def heads(experiments):
    tasks = names.tasks_of(experiments.get("heads", []))
    if not tasks:
        return None
    figure, axes = style.grid_of_panels(len(scores.COMPARED), len(tasks), height=2.2, sharex=True)
    arms = names.in_order({cells[0].arm for task in tasks for cells, _ in sweep(experiments, task).values()},
                          names.ARMS)
    counts, shown = set(), {}
    for j, task in enumerate(tasks):
        found = sweep(experiments, task)
        for ax, score in zip(axes[:, j], scores.COMPARED):
            _panel(ax, found, arms, score)
            if j == 0:
                ax.set_ylabel(score.label)
        counts |= {len(cells) for cells, _ in found.values()}
        shown |= found
        axes[0, j].set_title(task, loc="left")
        style.note(axes[0, j], "n = " + ", ".join(str(len(cells)) for cells, _ in found.values()))
        axes[-1, j].set_xlabel("number of heads k")
    ordered = [cells for _, (cells, _) in sorted(shown.items())]
    style.legend(figure, [style.handle(names.look_of(cells[0].arm, arms), names.label_of(cells[0].arm, cells),
                                       marker="o", linewidth=0) for cells in ordered])
    borrowed = [f"k = {k}" for k, (_, borrowed) in sorted(shown.items()) if borrowed]
    return figure, (
        f"Return and success at the end of training against the number of heads ({scores.seeds_text(counts)} "
        "seeds a point; n: from the smallest k on). PPO is k = 1. "
        + (f"Runs of experiment main: {' and '.join(borrowed)}. " if borrowed else "")
        + "Interquartile means with 95 % stratified bootstrap "
        f"intervals ({estimates.RESAMPLES} resamples); small dots: seeds; open dots: fewer than "
        f"{estimates.FEWEST} seeds, no interval.")


def _panel(ax, found, arms, score):
    means = {}
    for k, (cells, _) in found.items():
        values = list(scores.by_seed(cells, score).values())
        if not values:
            continue
        look = names.look_of(cells[0].arm, arms)
        ax.plot([k * 1.1] * len(values), values, ".", color=look.colour, markersize=3.5, alpha=0.5)
        estimate = estimates.iqm([values])
        dot(ax, k, estimate, look, zorder=3)
        means[k] = estimate.value
    ax.plot(list(means), list(means.values()), color=style.GREY, linewidth=1, zorder=1)
    ax.set_xscale("log")
    ax.set_xticks(list(found), [str(k) for k in found])
    ax.minorticks_off()
    if score.share:
        ax.set_ylim(-0.03, 1.03)
    else:
        ax.set_ylim(bottom=0)
        style.thousands(ax.yaxis)
