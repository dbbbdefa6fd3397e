"""The experiments' finished runs under results/, from the files of deploy/experimenter/result_files.py: one cell is one
run, TASK-ARM-sSEED."""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from names import meant
from result_files import DEFINITION, ResultFiles, ResultsError, read_rows

PROGRESS = ("steps", "return", "success", "success_end", "wall_seconds")
EVALUATION = ("steps", "success", "success_end", "return", "time_to_success", "success_200")
MAY_BE_EMPTY = {"time_to_success", "success_200"}  # or lack in a whole file
SHARES = {"success", "success_end", "success_200"}
REWARD_LIMIT = 10  # of one step, in every Meta-World task


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


def _read_tables(path, columns, by):
    """@return table of `columns` for each combination of texts that rows have in the columns `by`.
    @throws ResultsError naming the file and the line of what is wrong, OSError."""
    values = {}
    for where, row in read_rows(path, {*by, *columns} - MAY_BE_EMPTY):
        rows = values.setdefault(tuple(row[column] for column in by), [])
        rows.append([_number(row.get(column, ""), column, where) for column in columns])
        if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
            raise ResultsError(f"{where}: {columns[0]} does not grow within {row['run']}")
    return {name: dict(zip(columns, np.array(rows, dtype=float).T)) for name, rows in values.items()}


def _read_evaluations(path):
    """Run to table, by placements."""
    if not path.exists():
        return {}
    tables = {}
    for (run, placements), table in _read_tables(path, EVALUATION, ("run", "placements")).items():
        tables.setdefault(run, {})[placements] = table
    return tables


def _horizon(facts):
    match = re.search(r"^\s*horizon:\s*(\d+)", facts["config"], re.MULTILINE)
    if not match:
        raise ValueError("its configuration does not name the horizon")
    return int(match[1])


def _cell(files, facts, curves, evaluations):
    run = facts["run"]
    if run not in curves:
        raise ResultsError(f"{files.progress_path(facts['task'])} has no rows of {run}, which is in {files.runs_path}: "
                           "fetch both from git again, or repeat the run")
    try:
        return Cell(
            experiment=files.folder.name, task=facts["task"], arm=meant(facts["arm"]), seed=facts["seed"],
            method=str(facts["method"]), heads=int(facts["heads"]), horizon=_horizon(facts),
            progress=curves[run], evaluations=evaluations.get(run, {}))
    except KeyError as error:
        raise ResultsError(f"{files.runs_path}: {run}: no usable entry {error}") from None
    except (TypeError, ValueError) as error:
        raise ResultsError(f"{files.runs_path}: {run}: {error}") from None


def read_experiment(folder):
    """@return (cells of its finished runs, by seed; names of the runs that are not finished). @throws ResultsError."""
    files = ResultFiles(folder)
    try:
        runs = files.runs()
        evaluations = _read_evaluations(files.evaluations_path)
        curves = {}
        for task in sorted({facts["task"] for facts in runs.values()}):
            tables = _read_tables(files.progress_path(task), PROGRESS, ("run",))
            curves |= {run: table for (run,), table in tables.items()}
        begun = {path.parent.name for path in folder.glob("*/unfinished")}
    except OSError as error:
        raise ResultsError(f"{error.filename} cannot be read: {error.strerror}") from None
    cells = [_cell(files, facts, curves, evaluations) for facts in runs.values()]
    return sorted(cells, key=lambda cell: cell.seed), sorted({*begun, *evaluations, *curves} - {*runs})


def read_results(results):
    """@return (cells of finished runs, by name of the experiment; EXPERIMENT/RUN of those that are not finished).
    @throws ResultsError, also where there is no finished run at all."""
    results = Path(results)
    experiments, unfinished = {}, []
    for definition in sorted(results.glob(f"*/{DEFINITION}")):
        name = definition.parent.name
        cells, begun = read_experiment(definition.parent)
        unfinished += [f"{name}/{run}" for run in begun]
        if cells:
            experiments[name] = cells
    if not experiments:
        raise ResultsError(f"{results}/ holds no finished run of an experiment: none has EXPERIMENT/{DEFINITION} and "
                           "a line in EXPERIMENT/runs.jsonl. deploy/experiment makes them")
    return experiments, unfinished
