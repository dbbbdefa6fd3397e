"""One place where runs are made, one after the other: some cores and a DDS domain of its own."""

import json
import shlex
import signal
import subprocess

import children
import logs
from folders import shown
from result_files import ResultsError

# Longer than deploy/train takes to stop a learner that hangs.
TRAIN_STOP = ((signal.SIGINT, 120.0), (signal.SIGKILL, 10.0))
# The words of deploy/train about a run that does not get under way.
TROUBLE = (b"no actor has joined", b"the learner does not serve")
EVALUATE_STOP = ((signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0))


class CellFailed(Exception):
    """The cell cannot be made; the message says why and where to look."""


def stop_all(slots, events):
    """Ends all processes of the slots' cells, the runs with a checkpoint."""
    events.stop([slot.evaluation for slot in slots if slot.evaluation], EVALUATE_STOP)
    events.stop([slot.training for slot in slots if slot.training], TRAIN_STOP)
    events.drain()


class Slot:
    """Trains a cell and evaluates its milestones beside that, then publishes both. Not to be used
    by several threads; advance() is called whenever a child may have ended or a file come."""

    def __init__(self, cores, domain, settings, events, note):
        """@param note  called with what a person may want to know."""
        self._cores, self._domain, self._settings = cores, domain, settings
        self._events, self._note = events, note
        self.cell, self.files = None, None
        self.training = self.evaluation = self._log = None
        self._evaluating = None  # (update, placements)
        self._evaluated = None  # a row that is not written yet
        self._under_way = False

    @property
    def free(self):
        return self.cell is None

    def start(self, cell, files):
        """@throws OSError having changed nothing."""
        files.fetch()
        files.runs.mkdir(parents=True, exist_ok=True)
        self.training = self._spawn(self._train_command(cell, files), subprocess.PIPE)
        self._events.watch(self.training.stdout, self._on_train_says)
        self.cell, self.files = cell, files
        self._log = logs.Log(self._log_path())
        self._under_way = False

    def advance(self):
        """@return the cell that got done, or None. @throws CellFailed, or OSError: it may be called again."""
        if self.free:
            return None
        if self.files.started():
            self.files.note_revision(self._settings.revision)
            self.files.note_evaluation(self._settings.evaluation_facts(self.cell))
        self._end_evaluation()
        self._require_milestones(before=max(self.files.checkpoints(), default=0))
        if self.evaluation is None:
            self._begin_evaluation()
        if self.training is not None and self.training.poll() is not None:
            self._events.drain()
            code, self.training = self.training.returncode, None
            if code != 0:
                self._fail(f"deploy/train ended with {code}")
        if self.training is not None or self.evaluation is not None or self._due():
            return None
        self._require_milestones(before=self._settings.updates_of(self.cell) + 1)
        self._publish()
        done = self.cell
        self._clear()
        return done

    def carry(self):
        """To be called after stop_all(). @return None, or why the run cannot go on in another checkout."""
        return self.files.carry({update for update, _ in self._due()})

    # Training.

    def _on_train_says(self, line):
        self._log.append(line)
        if line.startswith(b"update ") and not self._under_way:
            self._under_way = True
            self._note(f"{self.cell.name}: under way")
        elif line.startswith(TROUBLE):
            self._note(f"{self.cell.name}: {line.decode(errors='surrogateescape')}")

    def _train_command(self, cell, files):
        settings, cores = self._settings, self._cores
        command = [str(settings.root / "deploy" / "train"), *cell.train_arguments()]
        command += ["--mujoco", settings.mujoco, "--build", str(settings.build)]
        command += ["--runs", str(files.runs), "--run", cell.name]
        command += ["--actors", str(len(cores)), "--domain", str(self._domain)]
        command += ["--set", f"runtime.learner_threads={len(cores)}"]
        command += ["--set", f"runtime.milestone_every={settings.milestone_every(cell)}"]
        return command + (["--resume"] if files.started() else [])

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
                       f"checkpoint; to make the run anew, remove "
                       f"{shlex.join([shown(self.files.run), shown(self.files.result / 'unfinished')])}")

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
        with logs.open_for_child(self._log_path()) as log:
            self.evaluation = self._spawn(command, subprocess.PIPE, stderr=log)

    def _end_evaluation(self):
        if self.evaluation is not None and self.evaluation.poll() is not None:
            self._take_evaluation()
        if self._evaluated is not None:
            self.files.add_evaluation(self._evaluated)
            self._evaluated = None

    def _take_evaluation(self):
        child, self.evaluation = self.evaluation, None
        if child.returncode != 0:
            self._fail(f"evaluating update {self._evaluating[0]} ended with {child.returncode}")
        report = json.loads(child.stdout.read())
        time = report["time_to_success"]
        self._evaluated = {
            "steps": report["steps"], "update": self._evaluating[0],
            "placements": self._evaluating[1], "episodes": report["episodes"],
            "success": report["success"], "success_end": report["success_end"],
            "return": report["return"], "time_to_success": "" if time is None else time,
            "success_200": report["success_200"]}
        self._note(f"{self.cell.name}: success {report['success']:.2f}, return {report['return']:.0f} of "
                   f"the mean action at {report['steps']} steps ({self._evaluating[1]})")

    # The end.

    def _publish(self):
        try:
            self.files.publish(self._facts())
        except ResultsError as error:  # a merge under way, say: the run stays as it is
            self._fail(f"{error}; then start again")

    def _facts(self):
        cell, settings = self.cell, self._settings
        inspect = [str(settings.build / "bin" / "metronome-learner"), "inspect", "--json",
                   str(self.files.run / "checkpoints" / "latest")]
        done = subprocess.run(inspect, capture_output=True)
        if done.returncode != 0:
            self._fail(f"its checkpoint: {done.stderr.decode(errors='surrogateescape').strip()}")
        held = json.loads(done.stdout)
        revisions = self.files.revisions()
        return {
            "run": cell.name, "experiment": cell.experiment, "task": cell.task, "arm": cell.arm,
            "seed": cell.seed, "method": cell.method, "heads": held["heads"], "steps": held["steps"],
            "engine": held["engine"], "revision": revisions[0],
            "later_revisions": revisions[1:], "processor": settings.processor,
            "weights_sha256": held["weights_sha256"],
            "command": settings.command_of(cell),
            **settings.evaluation_facts(cell),
            "wall_cores": len(self._cores),
        }

    def _fail(self, why):
        name, log = self.cell.name, self._log_path()
        stop_all([self], self._events)
        self._clear()
        raise CellFailed(f"{name}: {why}; see {shown(log)}")

    def _log_path(self):
        return self.files.runs / f"{self.cell.name}.log"

    def _clear(self):
        self._log.close()
        self.cell = self.files = self.training = self.evaluation = self._log = self._evaluated = None

    def _spawn(self, command, stdout, stderr=subprocess.STDOUT):
        pinned = ["taskset", "--cpu-list", ",".join(map(str, self._cores)), *command]
        return children.start(pinned, stdout=stdout, stderr=stderr)
