"""An experiment file (TOML): which runs it asks for.

    name = "main"                     # results go to results/NAME
    mujoco = "3.3.0"                  # engine
    tasks = ["assembly", "push"]
    seeds = [1, 2, 3]
    steps = 2000000                   # environment steps of a run
    milestones = 8                    # checkpoints to evaluate, evenly spaced, the last at the end

    [evaluate]                        # of every milestone, by the deterministic policy
    episodes = 50
    seed = 1000                       # of the placements
    placements = ["random", "mt1"]    # or "fixed": the run's own one

    [set]                             # configuration of every run (common/schema/config.proto)
    "ppo.epochs" = 10

    [arms.multihead]                  # method, heads, horizon, steps, seeds, tasks, and what differs
    method = "multihead"
    heads = 10
    set = { "ppo.discount" = 0.99 }

    [task.assembly]                   # what differs on one task
    set = { "collection.episodes_per_update" = 32 }

Later ones win: [set], then the task's, then the arm's. A run is named TASK-ARM-sSEED.
"""

import difflib
import tomllib
from dataclasses import dataclass

from options import RUN_NAME, RUN_NAME_RULE

ENGINES = ("2.2.2", "3.3.0")
PLACEMENTS = ("random", "fixed", "mt1", "benchmark")
_TOP = {"name", "mujoco", "tasks", "seeds", "steps", "milestones", "evaluate", "set", "arms", "task"}
_ARM = {"method", "heads", "horizon", "steps", "seeds", "tasks", "set"}
_TASK = {"set", "steps"}
_EVALUATE = {"episodes", "seed", "placements"}


class MatrixError(ValueError):
    """The experiment file cannot be right; the message says where."""


@dataclass(frozen=True)
class Evaluation:
    episodes: int
    seed: int
    placements: tuple


@dataclass(frozen=True)
class Cell:
    """One run of the matrix."""

    experiment: str
    task: str
    arm: str
    seed: int
    steps: int
    method: str
    heads: int | None
    horizon: int | None
    settings: tuple  # (path, value text), sorted

    @property
    def name(self):
        return f"{self.task}-{self.arm}-s{self.seed}"

    def train_arguments(self):
        """The arguments of deploy/train for this run, but for where and by how many processes."""
        words = [self.task, "--method", self.method]
        words += [] if self.heads is None else ["--heads", str(self.heads)]
        words += [] if self.horizon is None else ["--horizon", str(self.horizon)]
        words += ["--steps", str(self.steps), "--seed", str(self.seed)]
        for path, value in self.settings:
            words += ["--set", f"{path}={value}"]
        return words


@dataclass(frozen=True)
class Experiment:
    name: str
    mujoco: str
    milestones: int
    evaluation: Evaluation
    cells: tuple  # of Cell: all arms and tasks of the first seed, then of the second, ...


def _table(value, where):
    if not isinstance(value, dict):
        raise MatrixError(f"{where}: {value!r} is not a table")
    return value


def _known(table, names, where):
    for key in _table(table, where):
        if key not in names:
            near = difflib.get_close_matches(key, names, 1)
            hint = f"; did you mean '{near[0]}'?" if near else f" (known: {', '.join(sorted(names))})"
            raise MatrixError(f"{where}: unknown key '{key}'{hint}")


def _one_of(value, names, where):
    if value not in names:
        near = difflib.get_close_matches(str(value), names, 1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        raise MatrixError(f"{where}: '{value}' is not one of {', '.join(names)}{hint}")
    return value


def _whole(value, low, where):
    if not isinstance(value, int) or isinstance(value, bool) or value < low:
        raise MatrixError(f"{where}: {value!r} is not a whole number of at least {low}")
    return value


def _list(value, where):
    if not isinstance(value, list) or not value or any(value.count(entry) > 1 for entry in value):
        raise MatrixError(f"{where}: needs a list of at least one entry, each once")
    return value


def _name(value, where):
    """Of a folder and, for a run, of a DDS partition."""
    if not isinstance(value, str) or not RUN_NAME.fullmatch(value):
        raise MatrixError(f"{where}: {value!r} cannot be a name: {RUN_NAME_RULE}")
    return value


def _settings(table, where):
    for path, value in _table(table, where).items():
        if not isinstance(value, (str, int, float)):
            raise MatrixError(f"{where}: {path} must be a text, a number, true or false, not {value!r}; a path "
                              'with dots is one key, in quotes: "ppo.epochs" = 10')


def _text(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


def _evaluation(table):
    _known(table, _EVALUATE, "[evaluate]")
    placements = _list(table.get("placements", ["random"]), "[evaluate] placements")
    return Evaluation(
        episodes=_whole(table.get("episodes", 50), 1, "[evaluate] episodes"),
        seed=_whole(table.get("seed", 1000), 0, "[evaluate] seed"),
        placements=tuple(_one_of(p, PLACEMENTS, "[evaluate] placements") for p in placements),
    )


def _cell(data, task, arm_name, seed):
    arm, of_task = data["arms"][arm_name], data.get("task", {}).get(task, {})
    settings = {**data.get("set", {}), **of_task.get("set", {}), **arm.get("set", {})}
    where = f"[arms.{arm_name}]"
    steps = arm.get("steps", of_task.get("steps", data.get("steps")))
    heads, horizon = arm.get("heads"), arm.get("horizon")
    cell = Cell(
        experiment=data["name"],
        task=task,
        arm=arm_name,
        seed=_whole(seed, 0, f"{where} seeds"),
        steps=_whole(steps, 1, f"{where} steps"),
        method=_text(arm.get("method", "multihead")),
        heads=None if heads is None else _whole(heads, 1, f"{where} heads"),
        horizon=None if horizon is None else _whole(horizon, 1, f"{where} horizon"),
        settings=tuple(sorted((path, _text(value)) for path, value in settings.items())),
    )
    _name(cell.name, where)
    return cell


def _check_tables(data):
    _known(data, _TOP, "top level")
    for key in ("name", "tasks", "seeds", "arms"):
        if key not in data:
            raise MatrixError(f"'{key}' is missing")
    _name(data["name"], "name")
    _settings(data.get("set", {}), "[set]")
    for kind, keys in (("task", _TASK), ("arms", _ARM)):
        for name, table in _table(data.get(kind, {}), f"[{kind}]").items():
            _known(table, keys, f"[{kind}.{name}]")
            _settings(table.get("set", {}), f"[{kind}.{name}] set")
    if not data["arms"]:
        raise MatrixError("[arms]: needs at least one arm")


def load(path):
    """Reads an experiment file. @throws MatrixError naming the key that is wrong, OSError."""
    with open(path, encoding="utf-8-sig") as file:  # some editors begin a file by a byte-order mark
        try:
            data = tomllib.loads(file.read())
        except tomllib.TOMLDecodeError as error:
            raise MatrixError(str(error)) from None
        except UnicodeDecodeError as error:
            raise MatrixError(f"the file is not UTF-8: {error}") from None
    _check_tables(data)
    # Whether there are such tasks the programs say (settings.py).
    tasks = [_name(task, "tasks") for task in _list(data["tasks"], "tasks")]
    cells = []
    for name, arm in data["arms"].items():
        for seed in _list(arm.get("seeds", data["seeds"]), f"[arms.{name}] seeds"):
            for task in _list(arm.get("tasks", tasks), f"[arms.{name}] tasks"):
                cells.append(_cell(data, _name(task, f"[arms.{name}] tasks"), name, seed))
    for task in data.get("task", {}):
        _one_of(task, sorted({cell.task for cell in cells}), "[task]")
    arms = list(data["arms"])
    # Whole seeds first: what is there after an interruption compares all arms.
    cells.sort(key=lambda c: (c.seed, c.task, arms.index(c.arm)))
    return Experiment(
        name=data["name"],
        mujoco=_one_of(data.get("mujoco", "2.2.2"), ENGINES, "mujoco"),
        milestones=_whole(data.get("milestones", 8), 1, "milestones"),
        evaluation=_evaluation(data.get("evaluate", {})),
        cells=tuple(cells),
    )
