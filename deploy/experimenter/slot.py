"""One place where runs are made, one after the other: some cores and a DDS domain of its own."""

import json
import signal
import subprocess

import children
from progress import shown

TRAIN_STOP = ((signal.SIGINT, 90.0), (signal.SIGKILL, 10.0))
EVALUATE_STOP = ((signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0))


class CellFailed(Exception):
    """The cell cannot be made; the message says why and where to look."""


class Slot:
    """Trains a cell and evaluates its milestones beside that, then publishes both. Not to be used
    by several threads; advance() is called whenever a child may have ended or a file come."""

    def __init__(self, cores, domain, settings, events, note):
        """@param note  called with what a person may want to know."""
        self._cores, self._domain, self._settings = cores, domain, settings
        self._events, self._note = events, note
        self.cell, self.files = None, None
        self._train = self._evaluate = self._log = None
        self._evaluating = None  # (update, placements)
        self._under_way = False

    @property
    def free(self):
        return self.cell is None

    def start(self, cell, files):
        self.cell, self.files = cell, files
        files.fetch()
        files.runs.mkdir(parents=True, exist_ok=True)
        self._log = open(files.runs / f"{cell.name}.log", "ab")
        self._train = self._spawn(self._train_command(resume=files.started()), subprocess.PIPE)
        self._events.watch(self._train.stdout, self._on_train_says)
        self._under_way = False

    def advance(self):
        """@return whether the cell got done. @throws CellFailed."""
        if self.free:
            return False
        if self.files.started():
            self.files.note_revision(self._settings.revision)
            self.files.note_evaluation(self._settings.evaluation_facts(self.cell))
        self._end_evaluation()
        self._require_milestones(before=max(self.files.checkpoints(), default=0))
        if self._evaluate is None:
            self._begin_evaluation()
        if self._train is not None and self._train.poll() is not None:
            self._events.drain()
            code, self._train = self._train.returncode, None
            if code != 0:
                self._fail(f"deploy/train ended with {code}")
        if self._train is not None or self._evaluate is not None or self._due():
            return False
        self._require_milestones(before=self._settings.updates_of(self.cell) + 1)
        self.files.publish(self._facts())
        self._clear()
        return True

    def stop(self):
        """Ends the cell's processes, the run with a checkpoint."""
        children.stop([self._evaluate] if self._evaluate else [], EVALUATE_STOP)
        children.stop([self._train] if self._train else [], TRAIN_STOP)
        self._events.drain()

    def carry(self):
        """To be called after stop(). @return None, or why the run cannot go on in another checkout."""
        return self.files.carry({update for update, _ in self._due()})

    # Training.

    def _on_train_says(self, line):
        self._log.write(line + b"\n")
        self._log.flush()
        if line.startswith(b"update ") and not self._under_way:
            self._under_way = True
            self._note(f"{self.cell.name}: under way")

    def _train_command(self, resume):
        settings, cores = self._settings, self._cores
        command = [str(settings.root / "deploy" / "train"), *self.cell.train_arguments()]
        command += ["--mujoco", settings.mujoco, "--build", str(settings.build)]
        command += ["--runs", str(self.files.runs), "--run", self.cell.name]
        command += ["--actors", str(len(cores)), "--domain", str(self._domain)]
        command += ["--set", f"runtime.learner_threads={len(cores)}"]
        command += ["--set", f"runtime.milestone_every={settings.milestone_every(self.cell)}"]
        return command + (["--resume"] if resume else [])

    # Evaluation.

    def _due(self):
        """Milestones reached and not yet evaluated: (update, placements), oldest first."""
        there, known = self.files.checkpoints(), self.files.evaluated()
        return [(update, placements)
                for update in self._settings.milestones_of(self.cell) if update in there
                for placements in self._settings.evaluation.placements
                if (update, placements) not in known]

    def _require_milestones(self, before):
        """A milestone that the run has passed can be evaluated by its own checkpoint alone.
        @throws CellFailed where one before this update has neither checkpoint nor evaluation."""
        there, known = self.files.checkpoints(), self.files.evaluated()
        lost = sorted({update for update in self._settings.milestones_of(self.cell)
                       if update < before and update not in there
                       for placements in self._settings.evaluation.placements
                       if (update, placements) not in known})
        if lost:
            self._fail(f"milestones at update {', '.join(map(str, lost))} have neither an evaluation nor a "
                       f"checkpoint; to make the run anew, remove {shown(self.files.run)}/ and "
                       f"{shown(self.files.result)}/unfinished/")

    def _begin_evaluation(self):
        due = self._due()
        if not due:
            return
        update, placements = self._evaluating = due[0]
        evaluation, settings = self._settings.evaluation, self._settings
        command = [str(settings.build / "bin" / "metronome-actor"), "evaluate", "--json",
                   "--checkpoint", str(self.files.checkpoints()[update]),
                   "--episodes", str(evaluation.episodes), "--seed", str(evaluation.seed),
                   "--placements", placements, "--threads", str(len(self._cores))]
        self._evaluate = self._spawn(command, subprocess.PIPE, stderr=self._log)

    def _end_evaluation(self):
        if self._evaluate is None or self._evaluate.poll() is None:
            return
        child, self._evaluate = self._evaluate, None
        if child.returncode != 0:
            self._fail(f"evaluating update {self._evaluating[0]} ended with {child.returncode}")
        report = json.loads(child.stdout.read())
        time = report["time_to_success"]
        self.files.add_evaluation({
            "steps": report["steps"], "update": self._evaluating[0],
            "placements": self._evaluating[1], "episodes": report["episodes"],
            "success": report["success"], "success_end": report["success_end"],
            "return": report["return"], "time_to_success": "" if time is None else time})
        self._note(f"{self.cell.name}: success {report['success']:.2f}, return {report['return']:.0f} of "
                   f"the mean action at {report['steps']} steps ({self._evaluating[1]})")

    # The end.

    def _facts(self):
        cell, settings = self.cell, self._settings
        inspect = [str(settings.build / "bin" / "metronome-learner"), "inspect", "--json",
                   str(self.files.run / "checkpoints" / "latest")]
        held = json.loads(subprocess.run(inspect, check=True, capture_output=True).stdout)
        revisions = self.files.revisions()
        return {
            "experiment": cell.experiment, "cell": cell.name, "task": cell.task, "arm": cell.arm,
            "seed": cell.seed, "method": cell.method, "heads": held["heads"], "steps": held["steps"],
            "engine": held["engine"], "revision": revisions[0],
            "later_revisions": revisions[1:], "processor": settings.processor,
            "weights_sha256": held["weights_sha256"],
            "command": settings.command_of(cell),
            **settings.evaluation_facts(cell),
            "wall_cores": len(self._cores),
        }

    def _fail(self, why):
        name, log = self.cell.name, self._log.name
        self.stop()
        self._clear()
        raise CellFailed(f"{name}: {why}; see {shown(log)}")

    def _clear(self):
        self._log.close()
        self.cell = self.files = self._train = self._evaluate = self._log = None

    def _spawn(self, command, stdout, stderr=subprocess.STDOUT):
        pinned = ["taskset", "--cpu-list", ",".join(map(str, self._cores)), *command]
        return children.start(pinned, stdout=stdout, stderr=stderr)
