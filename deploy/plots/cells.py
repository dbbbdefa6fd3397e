"""The experiments' files under results/: one cell is one run, results/EXPERIMENT/TASK-ARM-sSEED/."""

import csv
import json
import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from names import meant

PROGRESS = ("steps", "return", "success", "success_end", "wall_seconds")
EVALUATION = ("steps", "success", "success_end", "return", "time_to_success", "success_200")
MAY_BE_MISSING = {"success_200"}  # from files that are older than it
MAY_BE_EMPTY = {"time_to_success", *MAY_BE_MISSING}
SHARES = {"success", "success_end", "success_200"}
REWARD_LIMIT = 10  # of one step, in every Meta-World task


class ResultsError(Exception):
    """A file under results/ cannot be used; the message names it and the remedy."""


@dataclass(frozen=True)
class Cell:
    """A finished run. Tables map a column to its values, (rows); steps grow from row to row."""

    experiment: str
    task: str
    arm: str  # what it means (names.meant), whatever the experiment's file calls it
    seed: int
    method: str
    heads: int
    horizon: int  # steps an episode
    progress: dict
    evaluations: dict = field(default_factory=dict)  # placements to table

    @property
    def steps(self):
        """Environment steps of the whole run."""
        return int(self.progress["steps"][-1])

    @property
    def largest_return(self):
        return REWARD_LIMIT * self.horizon


def _number(text, column, where):
    if text == "" and column in MAY_BE_EMPTY:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (column in SHARES and not 0 <= value <= 1):
        raise ResultsError(f"{where}: '{text}' cannot be a value of column {column}; "
                           "the file is damaged: fetch it from git again, or repeat the run")
    return value


def _check_last_line(path, number):
    """A number that was cut is a number all the same."""
    if not path.read_bytes().endswith(b"\n"):
        raise ResultsError(f"{path}:{number}: the line does not end; the file was cut")


def read_table(path, columns, keep=lambda row: True):
    """@return those of the CSV file's `columns`, as arrays, from the rows that `keep`; nan where there is no value.
    @throws ResultsError naming the file and the line of what is wrong."""
    values, names = [], None
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.reader(file)
            names = next(reader, [])
            missing = [column for column in columns if column not in (*names, *MAY_BE_MISSING)]
            if missing:
                raise ResultsError(f"{path}:1: there is no column {missing[0]}")
            for row in reader:
                where = f"{path}:{reader.line_num}"
                if len(row) != len(names):
                    raise ResultsError(f"{where}: {len(row)} fields where the first line names "
                                       f"{len(names)}; the file is damaged or was cut")
                record = dict(zip(names, row))
                if keep(record):
                    values.append([_number(record.get(column, ""), column, where) for column in columns])
                    if len(values) > 1 and values[-1][0] <= values[-2][0]:
                        raise ResultsError(f"{where}: {columns[0]} does not grow")
            _check_last_line(path, reader.line_num)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ResultsError(f"{path} cannot be read: {error}") from None
    return dict(zip(columns, np.array(values, dtype=float).reshape(-1, len(columns)).T))


def _read_evaluations(path):
    if not path.exists():
        return {}
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        found = sorted({row["placements"] or "" for row in csv.DictReader(file) if "placements" in row})
    tables = {}
    for placements in found:
        table = read_table(path, EVALUATION, lambda row: row["placements"] == placements)
        if len(table["steps"]):
            tables[placements] = table
    return tables


def _read_json(path):
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        return {**record, "task": str(record["task"]), "arm": str(record["arm"]),
                "seed": int(record["seed"]), "method": str(record["method"]),
                "heads": int(record["heads"])}
    except (OSError, ValueError) as error:
        raise ResultsError(f"{path} cannot be read: {error}") from None
    except (KeyError, TypeError) as error:
        raise ResultsError(f"{path}: no usable entry {error}") from None


def _read_horizon(path):
    try:
        match = re.search(r"^\s*horizon:\s*(\d+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    except OSError as error:
        raise ResultsError(f"{path} cannot be read: {error}") from None
    if not match:
        raise ResultsError(f"{path} does not name the horizon")
    return int(match[1])


def read_cell(folder):
    """@throws ResultsError."""
    run = _read_json(folder / "run.json")
    name = f"{run['task']}-{run['arm']}-s{run['seed']}"
    if name != folder.name:
        raise ResultsError(f"{folder}/run.json is that of {name}")
    progress = read_table(folder / "progress.csv", PROGRESS)
    if not len(progress["steps"]):
        raise ResultsError(f"{folder}/progress.csv has no rows")
    return Cell(
        experiment=folder.parent.name, task=run["task"], arm=meant(run["arm"]), seed=run["seed"],
        method=run["method"], heads=run["heads"],
        horizon=_read_horizon(folder / "config.textproto"), progress=progress,
        evaluations=_read_evaluations(folder / "evaluation.csv"))


def read_results(results):
    """@return (finished cells, by name of the experiment; folders of unfinished cells).
    A cell is finished once it has run.json.
    @throws ResultsError, also where there is no finished cell at all."""
    results = Path(results)
    experiments, unfinished = {}, []
    for definition in sorted(results.glob("*/experiment.toml")):
        cells = []
        for folder in sorted(path for path in definition.parent.iterdir() if path.is_dir()):
            if (folder / "run.json").exists():
                cells.append(read_cell(folder))
            else:
                unfinished.append(folder)
        if cells:
            experiments[definition.parent.name] = sorted(cells, key=lambda cell: cell.seed)
    if not experiments:
        raise ResultsError(f"{results}/ holds no finished run of an experiment: none has "
                           "EXPERIMENT/experiment.toml and EXPERIMENT/CELL/run.json. "
                           "deploy/experiment makes them")
    return experiments, unfinished
