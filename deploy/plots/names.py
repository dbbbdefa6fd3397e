"""What experiments, tasks and arms are called and drawn as, and in which order they stand.

The only place to touch for a nicer name or colour; what is not named here is drawn all the same, under
its own name, after those that are. Colours are those of Okabe and Ito, which the colour-blind can tell
apart.
"""

from dataclasses import dataclass

BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY, BLACK = "#CC79A7", "#E69F00", "#56B4E9", "#000000"


@dataclass(frozen=True)
class Look:
    label: str
    colour: str
    line: str = "-"


ARMS = {
    "multihead": Look("multi-head", BLUE),
    "correlated": Look("multi-head, k = 10, correlated noise", ORANGE),
    "correlated-k50": Look("multi-head, k = 50, correlated noise", ORANGE, "--"),
    "success-reward": Look("multi-head, k = 10, success rewarded by 10", PURPLE),
    "success-reward-25": Look("multi-head, k = 10, success rewarded by 25", GREEN),
    "one-configuration": Look("multi-head, k = 10, as on assembly", SKY),
    "ppo-success-reward-25": Look("PPO, success rewarded by 25", VERMILION),
    "ppo": Look("PPO", VERMILION),
    "ppo-time": Look("PPO + time", GREEN),
    "ppo-matched": Look("PPO, equal parameter count", ORANGE),
    "interleaved": Look("heads interleaved (t mod k)", PURPLE),
    "shuffled": Look("heads shuffled over time", SKY),
    "shared-critic": Look("one critic for all heads", ORANGE, "--"),
    "bootstrap": Look("bootstrap at the horizon", BLACK),
    "k2": Look("k = 2", "#440154"),
    "k5": Look("k = 5", "#3B528B"),
    "k10": Look("k = 10", "#21918C"),
    "k20": Look("k = 20", "#5EC962"),
    "k50": Look("k = 50", "#E3B505"),
    "t100-k20": Look("T = 100: multi-head, k = 20", BLUE, "--"),
    "t100-ppo": Look("T = 100: PPO", VERMILION, "--"),
    "t100-ppo-time": Look("T = 100: PPO + time", GREEN, "--"),
}
_SPARE = (PURPLE, ORANGE, SKY, BLACK, BLUE, VERMILION, GREEN)
_LINES = ("-", "--", "-.", ":")


def in_order(found, known):
    """`found` in the order of `known`, unknown ones last."""
    rank = {name: i for i, name in enumerate(known)}
    return sorted(found, key=lambda name: (rank.get(name, len(rank)), name))


def tasks_of(cells):
    return sorted({cell.task for cell in cells})


def arms_of(cells):
    return in_order({cell.arm for cell in cells}, ARMS)


def look_of(arm, arms):
    """@param arms  all that are drawn together, so that each gets another look."""
    if arm in ARMS:
        return ARMS[arm]
    taken = {(ARMS[name].colour, ARMS[name].line) for name in arms if name in ARMS}
    free = [(colour, line) for line in _LINES for colour in _SPARE if (colour, line) not in taken]
    i = [name for name in arms if name not in ARMS].index(arm)
    return Look(arm, *free[i % len(free)])


def label_of(arm, cells):
    """With k, where the name does not say it and all runs agree."""
    label = look_of(arm, arms_of(cells)).label
    heads = {cell.heads for cell in cells if cell.arm == arm and cell.method == "multihead"}
    return f"{label}, k = {heads.pop()}" if len(heads) == 1 and arm == "multihead" else label
