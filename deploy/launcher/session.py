"""One training session: the learner, its actors, and the order in which they start and stop."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time

import children
import options as command_line
import progress

RESTARTS = 5  # of one actor, after which it is given up
TAIL = 20  # lines of a log shown when its process failed
SERIOUS = re.compile(rb" (warning|error|critical): ")  # lines of the learner's log shown at once
COMPLAINTS = 20  # so many of them at most
# Updates and checkpoints end within seconds; a learner that takes longer than this hangs.
LEARNER_STOP = ((signal.SIGINT, 60.0), (signal.SIGTERM, 10.0), (signal.SIGKILL, 10.0))
ACTOR_STOP = ((signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0))
ACTOR_FINISH = 10.0  # seconds that actors have to see that the run is finished


class Actor:
    """One of our actor processes, and how often it was started."""

    def __init__(self, index, log):
        self.index, self.log = index, log
        self.process, self.starts = None, 0
        self.start_at = 0.0  # time.monotonic() of the next start; None: none is planned
        self.given_up = False

    def start(self, command):
        self.starts += 1
        self.start_at = None
        with open(self.log, "ab") as log:
            self.process = children.start(command, stdout=log, stderr=log)


class Session:
    """Not to be reused. run() returns the process's exit code."""

    def __init__(self, options):
        self._options = options
        self._view = progress.PlainView()
        self._events = children.Events()
        self._started = None  # the learner's word that it accepted the run
        self._finished = {}  # its last word
        self._early, self._log = [], None
        self._complaints = 0
        self._actors = []
        self._stop_signal = None
        self._failed = False
        self._learner = None

    def run(self):
        try:
            return self._run()
        finally:
            running = [actor.process for actor in self._actors if actor.process]
            children.stop(
                running + [self._learner] * (self._learner is not None), ((signal.SIGKILL, 5.0),)
            )

    def _run(self):
        self._learner = children.start(
            command_line.learner_command(self._options),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self._events.watch(self._learner.stdout, self._on_progress)
        self._events.watch(self._learner.stderr, self._on_log)
        stop_deadline, steps = None, list(LEARNER_STOP)
        while self._learner.poll() is None:
            self._tend_actors()
            for number in self._events.wait(self._timeout(stop_deadline)):
                self._stop_signal = self._stop_signal or number
                # A second Ctrl-C, or Ctrl-C again while it hangs, goes one step further.
                stop_deadline = 0.0
            if self._failed and stop_deadline is None:
                stop_deadline = 0.0
            if stop_deadline is not None and time.monotonic() >= stop_deadline and steps:
                number, seconds = steps.pop(0)
                self._learner.send_signal(number)
                stop_deadline = time.monotonic() + seconds
        self._events.drain()
        self._end_actors()
        self._view.close()
        return self._report(self._learner.returncode)

    def _timeout(self, stop_deadline):
        times = [actor.start_at for actor in self._actors if actor.start_at is not None]
        times += [] if stop_deadline is None else [stop_deadline]
        return max(0.0, min(times) - time.monotonic()) if times else None

    # What the learner says.

    def _on_progress(self, line):
        try:
            record = json.loads(line)
        except ValueError:
            self._on_log(line)
            return
        event = record.get("event")
        if event == "started":
            self._on_started(record)
        elif event in ("finished", "interrupted"):
            self._finished = record
        elif event is None:
            self._view.update(record)

    def _on_started(self, record):
        self._started = record
        self._view = progress.make_view(self._options.task or self._options.run)
        logs = self._options.folder / "logs"
        logs.mkdir(parents=True, exist_ok=True)
        self._log = open(logs / "learner.log", "ab", buffering=0)
        for line in self._early:
            self._on_log(line)
        # A run that was finished before needs none; they would wait for a learner that has ended.
        count = self._options.actors if record["update"] < record["updates_total"] else 0
        self._actors = [Actor(i, logs / f"actor-{i}.log") for i in range(count)]
        self._view.note(
            f"run {self._options.run}: learner and {len(self._actors)} actors; "
            f"logs in {progress.shown(logs)}/"
        )
        if not self._options.actors:
            self._view.note(
                "no actor here: start them with build/bin/metronome-actor run --run "
                f"{self._options.run}"
            )

    def _on_log(self, line):
        if not self._log:
            self._early.append(line)
            return
        self._keep(line)
        if SERIOUS.search(line) and self._complaints < COMPLAINTS:
            self._complaints += 1
            self._view.note(line.decode(errors="replace"))
            if self._complaints == COMPLAINTS:
                self._view.note("further warnings and errors go to the learner's log alone")

    def _keep(self, line):
        try:
            self._log.write(line + b"\n")
        except OSError:  # a full disk costs log lines, never the run
            pass

    # Actors.

    def _tend_actors(self):
        for actor in self._actors:
            if actor.process and actor.start_at is None and actor.process.poll() is not None:
                self._on_actor_end(actor)
            if actor.start_at is not None and time.monotonic() >= actor.start_at:
                actor.start(command_line.actor_command(self._options, actor.index, self._started))
        self._failed = bool(self._actors) and all(actor.given_up for actor in self._actors)

    def _on_actor_end(self, actor):
        code, actor.process = actor.process.returncode, None
        if code == 0 or self._stop_signal or self._finished:
            return
        what = f"actor {actor.index} ended with {_ending(code)}"
        if actor.starts > RESTARTS:
            actor.given_up = True
            self._view.note(
                f"{what} for the {actor.starts}th time and is given up; {progress.shown(actor.log)}:"
            )
            self._view.note(_tail(actor.log))
            return
        self._view.note(f"{what}; starting it again ({progress.shown(actor.log)})")
        # At once the first time; then 1, 2, 4, ... seconds, for causes that pass.
        actor.start_at = time.monotonic() + (
            0.0 if actor.starts == 1 else 2.0 ** (actor.starts - 2)
        )

    def _end_actors(self):
        running = [actor.process for actor in self._actors if actor.process]
        if self._done():
            children.stop(running, ((0, ACTOR_FINISH),))
        children.stop(running, ACTOR_STOP)

    # The end.

    def _done(self):
        return self._learner.returncode == 0 and self._finished.get("event") == "finished"

    def _report(self, code):
        options = self._options
        # A code of its own says what the learner could not do: leave a checkpoint, say.
        stopped = self._stop_signal and not 0 < code < 128
        if self._started is None and not self._stop_signal:
            sys.stderr.write(b"\n".join(self._early + [b""]).decode(errors="replace"))
            if not self._early:
                sys.stderr.write(f"deploy/train: the learner ended with {_ending(code)}\n")
            return _exit_code(code)
        if self._failed:
            print(
                "deploy/train: no actor stays up, so the run was stopped (see above)",
                file=sys.stderr,
            )
        elif code != 0 and not stopped:
            print(
                f"deploy/train: the learner ended with {_ending(code)}; its last lines:",
                file=sys.stderr,
            )
            print(_tail(options.folder / "logs" / "learner.log"), file=sys.stderr)
        if self._started:
            self._say_results(self._done())
        if stopped and not self._done():
            return 128 + self._stop_signal
        return 1 if self._failed else _exit_code(code)

    def _say_results(self, done):
        options = self._options
        folder, latest = options.folder, options.folder / "checkpoints" / "latest"
        message = self._finished.get("message", f"run {options.run}")
        print(f"{'finished' if done else 'stopped'}: {message}")
        print(f"  results     {progress.shown(folder)}/progress.csv")
        print(f"  curves      tensorboard --logdir {progress.shown(folder)}")
        newest = f" -> {os.readlink(latest)}" if latest.is_symlink() else ""
        print(f"  checkpoint  {progress.shown(latest)}{newest}")
        actor = progress.shown(options.build / "bin" / "metronome-actor")
        print(f"  evaluate    {actor} evaluate --checkpoint {progress.shown(latest)}")
        if not done:
            named = [] if options.named else ["--run", options.run]
            print(
                f"  go on       {shlex.join(command_line.resume_command() + named + ['--resume'])}"
            )
        sys.stdout.flush()


def _ending(code):
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"


def _exit_code(code):
    return code if code >= 0 else 128 - code


def _tail(path):
    with open(path, "rb") as log:
        log.seek(max(0, os.path.getsize(path) - 65536))
        lines = log.read().decode(errors="replace").splitlines()
    return "\n".join("  " + line for line in lines[-TAIL:])
