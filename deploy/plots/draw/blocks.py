"""Blocks of time given to other heads: what the policy is worth then."""

import matplotlib.pyplot as plt
import numpy as np

import style


def exchange(found):
    """@param found  task to exchange.Exchange.  @return (figure, caption), or None."""
    if not found:
        return None
    figure, axes = style.grid_of_panels(2, len(found), width=2.75, height=2.75)
    for j, (task, policy) in enumerate(found.items()):
        _panel(axes[0, j], policy.success)
        image = _panel(axes[1, j], policy.returns / policy.returns[0, 0])
        axes[0, j].set_title(task, loc="left")
        axes[1, j].set_xlabel("head that acts")
    for row, label in zip(axes, ("success", "return, of the policy's own")):
        row[0].set_ylabel("block of time")
        figure.colorbar(image, ax=row, label=label, shrink=0.9)
    episodes = sorted({policy.episodes for policy in found.values()})
    return figure, (
        "The committed policies under their mean action, each block of time given to each head in turn, all other "
        "blocks to their own heads (the diagonal is the policy as it is); last row: one head in all blocks. Above: "
        "share of episodes with success at any step; below: mean return, as a share of that of the policy as it is. "
        f"{', '.join(map(str, episodes))} placements that no training run draws, the same for all. One policy a task.")


def _panel(ax, values):
    heads = values.shape[1]
    # A gap before the last row, which is another kind of thing.
    rows = np.vstack([values[:-1], np.full((1, heads), np.nan), values[-1:]])
    image = ax.imshow(rows, cmap=plt.get_cmap("viridis"), vmin=0, vmax=1, aspect="auto")
    ax.set_xticks(range(heads))
    ax.set_yticks([*range(heads), heads + 1], [*map(str, range(heads)), "all"])
    ax.grid(visible=False)
    ax.tick_params(length=0)
    for side in ax.spines.values():
        side.set_visible(False)
    return image
