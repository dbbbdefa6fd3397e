"""Where a cell's files lie while it is made, and what of them goes into results/.

Until the cell is done results/EXPERIMENT/CELL/unfinished/ may hold checkpoints and the logs so far, from which the
run goes on in any other checkout; then it is one run of those in results/EXPERIMENT/ (result_files.py).
"""

import contextlib
import csv
import io
import json
import os
import re
import shutil

import whole_files
from options import is_run

CHECKPOINT = re.compile(r"(\d{6,})\.ckpt")
# Those columns of progress.csv that go into results/; whoever wants the others makes the run again.
_OF_CURVE = re.compile(r"steps|update|(return|success)(_.+)?|wall_seconds")
EVALUATION_COLUMNS = ["steps", "update", "placements", "episodes", "success", "success_end", "return",
                      "time_to_success", "success_200"]
EVALUATION_FACTS = "evaluation.json"
LARGEST_CARRIED = 1 << 20  # bytes of a checkpoint that is kept in the repository


def _checkpoints_in(folder):
    """Version to path of the checkpoint files there are."""
    matches = ((CHECKPOINT.fullmatch(path.name), path) for path in folder.glob("*.ckpt"))
    return {int(match.group(1)): path for match, path in matches if match}


def _read_json(path):
    """None where there is no such file."""
    try:
        return json.loads(path.read_text())
    except OSError:
        return None


class CellFiles:
    def __init__(self, cell, runs, results):
        """@param results  ResultFiles of the cell's experiment."""
        self.name = cell.name
        self.run = runs / cell.experiment / cell.name
        self.runs = runs / cell.experiment
        self.result = results.folder / cell.name
        self.results = results

    # The run.

    def started(self):
        return is_run(self.run)

    def steps_done(self):
        """Of the run so far; 0 where it has not begun."""
        try:
            with open(self.run / "progress.csv", "rb") as file:
                file.seek(max(0, os.path.getsize(file.name) - 65536))
                rows = file.read().decode().splitlines()
            return int(rows[-1].split(",")[0]) if len(rows) > 1 else 0
        except (OSError, ValueError):
            return 0

    def checkpoints(self):
        """Version to path of the files there are."""
        return _checkpoints_in(self.run / "checkpoints")

    def revisions(self):
        try:
            return (self.run / "revisions").read_text().split()
        except OSError:
            return []

    def note_revision(self, revision):
        if revision not in self.revisions():
            whole_files.write(self.run / "revisions", "".join(f"{each}\n" for each in [*self.revisions(), revision]))

    # Milestones' evaluations.

    def note_evaluation(self, facts):
        """Keeps how the run's milestones are chosen and evaluated."""
        path = self.run / EVALUATION_FACTS
        if not path.exists():
            whole_files.write(path, json.dumps(facts) + "\n")

    def evaluated(self):
        """Rows so far, by (update, placements)."""
        try:
            with open(self._evaluation(), newline="") as file:
                return {(int(row["update"]), row["placements"]): row for row in csv.DictReader(file)}
        except FileNotFoundError:
            return {}

    def add_evaluation(self, row):
        rows = self.evaluated()
        rows[int(row["update"]), row["placements"]] = row
        text = io.StringIO()
        writer = csv.DictWriter(text, EVALUATION_COLUMNS, lineterminator="\n")
        writer.writeheader()
        for key in sorted(rows):
            writer.writerow(rows[key])
        whole_files.write(self._evaluation(), text.getvalue())

    def _evaluation(self):
        return self.run / "evaluation.csv"

    def made_by(self):
        """Those settings of a cell under way that are known, by their names in runs.jsonl; and the folder that they
        are known from."""
        folder = self.run if self.started() else self.result / "unfinished"
        return _read_json(folder / EVALUATION_FACTS) or {}, folder

    # Results.

    def publish(self, facts):
        """Puts the finished run into results/. @throws ResultsError, OSError: it may be called again."""
        config = (self.run / "config.textproto").read_text()
        self.results.publish({**facts, "config": config}, self._curve(), self.evaluated().values())
        self.drop_carried()

    def _curve(self):
        with open(self.run / "progress.csv", newline="") as file:
            return [{name: value for name, value in row.items() if _OF_CURVE.fullmatch(name)}
                    for row in csv.DictReader(file)]

    # Carrying on elsewhere.

    def carry(self, due):
        """Keeps in results/ what another checkout needs to go on with the run.
        @param due  versions whose evaluation is still to come: no later checkpoint can make up for them.
        @return None, or why that is not possible."""
        there = self.checkpoints()
        if not there:
            return None
        latest = self.run / "checkpoints" / "latest"
        newest = latest.resolve() if latest.exists() else there[max(there)]
        carried = {newest, *(there[version] for version in due)}
        if max(path.stat().st_size for path in carried) > LARGEST_CARRIED:
            return f"{self.name}: its checkpoint is larger than 1 MB and is not kept in results/"
        target, partial = self.result / "unfinished", self.result / "unfinished.tmp"
        shutil.rmtree(partial, ignore_errors=True)
        (partial / "checkpoints").mkdir(parents=True)
        for path in carried:
            shutil.copyfile(path, partial / "checkpoints" / path.name)
        for name in ("config.textproto", "progress.csv", "evaluation.csv", EVALUATION_FACTS, "revisions"):
            if (self.run / name).exists():
                shutil.copyfile(self.run / name, partial / name)
        shutil.rmtree(target, ignore_errors=True)
        os.replace(partial, target)
        return None

    def drop_carried(self):
        """Of a run that is done; a stop may have left it."""
        shutil.rmtree(self.result / "unfinished", ignore_errors=True)
        with contextlib.suppress(OSError):
            self.result.rmdir()

    def fetch(self):
        """Makes the run's folder from what was carried. @return whether there was anything."""
        source = self.result / "unfinished"
        if self.started() or not source.is_dir():
            return False
        self.runs.mkdir(parents=True, exist_ok=True)
        partial = self.runs / (self.name + ".tmp")
        shutil.rmtree(partial, ignore_errors=True)
        shutil.copytree(source, partial)
        carried = _checkpoints_in(partial / "checkpoints")
        (partial / "checkpoints" / "latest").symlink_to(carried[max(carried)].name)
        shutil.rmtree(self.run, ignore_errors=True)  # what a start leaves that was killed before it began a run
        os.replace(partial, self.run)
        return True
