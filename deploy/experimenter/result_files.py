"""The finished runs of an experiment, in few files under results/EXPERIMENT/ that a person and a diff can read.

runs.jsonl          a line a run: what was run, where, the digest of its weights, its whole configuration
evaluations.csv     the milestones of all runs under the mean action
progress/TASK.csv   the curves of all runs of a task

All are sorted by run, so that a new run is one block of a diff, whoever made it. A column that a run lacks is empty
there. A run is finished once it has its line in runs.jsonl, which is written last.
"""

import contextlib
import csv
import fcntl
import io
import json
import re
import shutil

import whole_files

DEFINITION = "experiment.toml"
_RUN = re.compile(r".+-s\d+")
_REMEDY = "the file is damaged: fetch it from git again"


class ResultsError(Exception):
    """A file under results/ cannot be used; the message names it and the remedy."""


def order(run):
    """Sorts runs' names: seed 10 comes after seed 9."""
    name, _, seed = run.rpartition("-s")
    return name, int(seed)


def read_rows(path, columns=()):
    """Yields (FILE:LINE, row) of a table of runs; a row maps columns to texts.
    @throws ResultsError, also where one of `columns` is not there; OSError."""
    try:
        text = path.read_bytes().decode()
        reader = csv.reader(io.StringIO(text, newline=""))
        names = next(reader, [])
        for column in ("run", *columns):
            if column not in names:
                raise ResultsError(f"{path}:1: there is no column {column}; {_REMEDY}")
        for fields in reader:
            where = f"{path}:{reader.line_num}"
            if len(fields) != len(names):
                raise ResultsError(f"{where}: {len(fields)} fields where the first line names {len(names)}; {_REMEDY}")
            row = dict(zip(names, fields))
            if not _RUN.fullmatch(row["run"]):
                raise ResultsError(f"{where}: '{row['run']}' cannot be a run; {_REMEDY}")
            yield where, row
        if not text.endswith("\n"):  # a number that was cut is a number all the same
            raise ResultsError(f"{path}:{reader.line_num}: the line does not end, the file was cut; {_REMEDY}")
    except (UnicodeDecodeError, csv.Error) as error:
        raise ResultsError(f"{path} cannot be read: {error}; {_REMEDY}") from None


def _facts(line, where):
    try:
        facts = json.loads(line)
        run, meant = facts["run"], f"{facts['task']}-{facts['arm']}-s{facts['seed']:d}"
    except ValueError as error:
        raise ResultsError(f"{where}: not a run in JSON ({error}); {_REMEDY}") from None
    except (KeyError, TypeError) as error:
        raise ResultsError(f"{where}: no usable entry {error}; {_REMEDY}") from None
    if run != meant:
        raise ResultsError(f"{where}: the line of '{run}' tells of {meant}; {_REMEDY}")
    return facts


def _put(path, run, rows):
    """Gives the run these rows of a table, in place of those that it has there."""
    kept = [row for _, row in read_rows(path) if row["run"] != run] if path.exists() else []
    new = [{"run": run, **row} for row in rows]
    columns = dict.fromkeys(column for row in (*kept, *new) for column in row)
    if not columns:
        return
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(sorted([*kept, *new], key=lambda row: order(row["run"])))
    path.parent.mkdir(exist_ok=True)
    whole_files.write(path, text.getvalue())


class ResultFiles:
    def __init__(self, folder):
        self.folder = folder
        self.runs_path = folder / "runs.jsonl"
        self.evaluations_path = folder / "evaluations.csv"

    def progress_path(self, task):
        return self.folder / "progress" / f"{task}.csv"

    def runs(self):
        """Finished runs, by name: what runs.jsonl says of each. @throws ResultsError, OSError."""
        try:
            lines = self.runs_path.read_bytes().decode().splitlines()
        except FileNotFoundError:
            return {}
        except UnicodeDecodeError as error:
            raise ResultsError(f"{self.runs_path} cannot be read: {error}; {_REMEDY}") from None
        runs = {}
        for number, line in enumerate(lines, 1):
            facts = _facts(line, f"{self.runs_path}:{number}")
            if facts["run"] in runs:
                raise ResultsError(f"{self.runs_path}:{number}: another line of {facts['run']}: remove one of them")
            runs[facts["run"]] = facts
        return runs

    def define(self, experiment_file):
        """Keeps the file that asks for the runs."""
        self.folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(experiment_file, self.folder / DEFINITION)

    def publish(self, facts, progress, evaluations):
        """Adds a finished run; several processes may do so at once.
        @param facts  its line: run, task, arm, seed, and whatever else is known.
        @param progress, evaluations  its rows, column to text.
        @throws ResultsError if a file is damaged, or OSError; it may be called again."""
        run = facts["run"]
        with self._alone():
            runs = {**self.runs(), run: facts}
            _put(self.progress_path(facts["task"]), run, progress)
            _put(self.evaluations_path, run, evaluations)
            lines = (json.dumps(runs[each]) + "\n" for each in sorted(runs, key=order))
            whole_files.write(self.runs_path, "".join(lines))

    @contextlib.contextmanager
    def _alone(self):
        """While no other process publishes in this folder."""
        self.folder.mkdir(parents=True, exist_ok=True)
        # There before the first run and never replaced; a file for the lock alone would lie in results/ for good.
        with open(self.folder / DEFINITION, "ab") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
