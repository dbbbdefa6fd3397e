"""Names, looks and sequence of experiments, tasks and arms.

The only place to touch for a new arm. One arm has one label and one colour in every figure, and no other arm has that
colour; arms that meet in a figure can be told apart by the colour-blind too (tests/figures/test_drawing.py). An arm that
is not named here is drawn all the same, under its own name, after those that are.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Look:
    label: str
    colour: str
    line: str = "-"


ARMS = {
    "multihead": Look("multi-head", "#0072B2"),
    "correlated": Look("multi-head, k = 10, correlated noise", "#20B2AA"),
    "correlated-k50": Look("multi-head, k = 50, correlated noise", "#E15759", "--"),
    "success-reward": Look("multi-head, k = 10, success rewarded by 10", "#E3B505"),
    "success-reward-25": Look("multi-head, k = 10, success rewarded by 25", "#882255"),
    "ppo-success-reward-25": Look("PPO, success rewarded by 25", "#6B4E16"),
    "ppo": Look("PPO", "#D55E00"),
    "ppo-time": Look("PPO + time", "#009E73"),
    "ppo-matched": Look("PPO, equal parameter count", "#661100"),
    "interleaved": Look("heads interleaved (t mod k)", "#937860"),
    "shuffled": Look("heads shuffled over time", "#2F4F4F"),
    "shared-critic": Look("one critic for all heads", "#440154", "--"),
    "bootstrap": Look("bootstrap at the horizon", "#A5AA99"),
    "k2": Look("multi-head, k = 2", "#8C564B"),
    "k5": Look("multi-head, k = 5", "#DDCC77"),
    "k20": Look("multi-head, k = 20", "#DA8BC3"),
    "k50": Look("multi-head, k = 50", "#332288"),
    "forgetting": Look("scale of rewards forgets", "#FF8C00"),
    "fast-std": Look("standard deviations learnt quickly", "#0000FF"),
    "sac": Look("SAC, multi-head", "#AA1155"),
    "sac-single": Look("SAC, one head", "#E69F00"),
    "sac-single-time": Look("SAC, one head + time", "#66C2A5"),
    "sac-ratio-4": Look("SAC, multi-head, 4 samples a step", "#3B7A3B", "--"),
    "sac-ratio-16": Look("SAC, multi-head, 16 samples a step", "#1B1B3A", "--"),
    "task-time": Look("heads by task and time", "#330000"),
    "t100-k20": Look("T = 100: multi-head, k = 20", "#88CCEE", "--"),
    "t100-ppo": Look("T = 100: PPO", "#F28E2B", "--"),
}
# Arms that are another one by their settings, on other tasks: drawn and called as that one.
_SAME = {"one-configuration": "success-reward-25"}
# Of arms that are not named here; no arm above has one of these colours.
_SPARE = ("#CC79A7", "#7A9A01", "#5E4FA2", "#00B8D4", "#FF6F91")
_LINES = ("-", "--", "-.", ":")


def meant(arm):
    """@return the arm that an experiment's arm of this name is."""
    return _SAME.get(arm, arm)


def in_order(found, known):
    """`found` in the order of `known`, unknown ones last."""
    rank = {name: i for i, name in enumerate(known)}
    return sorted(found, key=lambda name: (rank.get(name, len(rank)), name))


def tasks_of(cells):
    return sorted({cell.task for cell in cells})


def arms_of(cells):
    return in_order({cell.arm for cell in cells}, ARMS)


def look_of(arm, arms):
    """@param arms  all that are drawn together, so that each that is not named here gets another look."""
    if arm in ARMS:
        return ARMS[arm]
    i = [name for name in arms if name not in ARMS].index(arm)
    return Look(arm, _SPARE[i % len(_SPARE)], _LINES[i // len(_SPARE) % len(_LINES)])


def label_of(arm, cells):
    """With k, where the name does not say it and all runs agree."""
    label = look_of(arm, arms_of(cells)).label
    heads = {cell.heads for cell in cells if cell.arm == arm and cell.method == "multihead"}
    return f"{label}, k = {heads.pop()}" if len(heads) == 1 and arm == "multihead" else label
