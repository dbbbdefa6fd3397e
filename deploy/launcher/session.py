"""One training session: the learner, its actors, and the order in which they start and stop."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
import traceback

import children
import logs
import options as command_line
import progress
from folders import shown, typed
from patience import Patience

RESTARTS = 5  # of one actor, after which it is given up
SERIOUS = re.compile(rb" (warning|error|critical): ")  # lines of the learner's log shown at once
IDLE = re.compile(rb"envs beyond half of that are often idle")  # among them, what the launcher says itself
JOINED = re.compile(rb" info: actor .* joins with ")  # as learner/collect/actor_registry.cc says it
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
        """@throws OSError where no process can be started."""
        self.starts += 1
        self.start_at = None
        with logs.open_for_child(self.log) as log:
            self.process = children.start(command, stdout=log, stderr=log)

    def start_later(self):
        """At once the first time; then in 1, 2, 4, ... seconds, for causes that pass."""
        self.start_at = time.monotonic() + (
            0.0 if self.starts == 1 else 2.0 ** (self.starts - 2)
        )


class Session:
    """Not to be reused. run() returns the process's exit code."""

    def __init__(self, options, outlets=()):
        """@param outlets  terminal.Outlets to write to while there is nothing else to do."""
        self._options = options
        self._view = progress.PlainView()
        self._events = children.Events()
        self._events.relieve(outlets)
        self._patience = Patience()
        self._started = None  # the learner's word that it accepted the run
        self._finished = {}  # its last word
        self._early, self._log = [], None
        self._shown = None  # how many of the early lines a person has seen, once they are shown
        self._complaints = 0
        self._is_capped = False  # fewer actors than cores, which was said
        self._actors = []
        self._stop_signal = None
        self._failed = False
        self._learner = None

    def run(self):
        try:
            return self._run()
        except Exception:  # a fault of ours must not cost the run: it ends with a checkpoint
            self._events.mute()
            self._stop_all()
            self._view.close()
            traceback.print_exc()
            print(f"{command_line.NAME}: stopped by the fault above, which is its own", file=sys.stderr)
            if self._started:
                again = command_line.resume_command(self._options)
                print(f"  go on       {again}", file=sys.stderr)
            return 1
        finally:
            self._stop_all()

    def _stop_all(self):
        self._events.stop([self._learner] if self._learner else [], LEARNER_STOP)
        self._events.stop(self._running(), ACTOR_STOP)

    def _run(self):
        # Killed as we may be, it leaves a checkpoint.
        self._learner = children.start(
            command_line.learner_command(self._options),
            at_our_death=signal.SIGTERM,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self._events.watch(self._learner.stdout, self._on_progress)
        self._events.watch(self._learner.stderr, self._on_log)
        stop_deadline, steps = None, list(LEARNER_STOP)
        while self._learner.poll() is None:
            self._tend_actors()
            self._say_what_is_missing()
            for number in self._events.wait(self._timeout(stop_deadline)):
                self._stop_signal = self._stop_signal or number
                # A second Ctrl-C, or Ctrl-C again while it hangs, goes one step further.
                stop_deadline = 0.0
            if self._failed and stop_deadline is None:
                stop_deadline = 0.0
            if stop_deadline is not None and time.monotonic() >= stop_deadline and steps:
                self._patience.end()
                number, seconds = steps.pop(0)
                self._learner.send_signal(number)
                stop_deadline = time.monotonic() + seconds
        self._events.drain()
        self._end_actors()
        self._view.close()
        return self._report(self._learner.returncode)

    def _timeout(self, stop_deadline):
        times = [actor.start_at for actor in self._actors if actor.start_at is not None]
        times += [at for at in (stop_deadline, self._patience.ends_at) if at is not None]
        return max(0.0, min(times) - time.monotonic()) if times else None

    # The learner's messages.

    def _on_progress(self, line):
        try:
            record = json.loads(line.decode(errors="surrogateescape"))
        except ValueError:
            record = None
        if not isinstance(record, dict):
            self._on_log(line)
            return
        event = record.get("event")
        if event == "started":
            self._on_started(record)
        elif event in ("finished", "interrupted"):
            self._finished = record
        elif event is None:
            self._patience.end()
            self._view.update(record)

    def _on_started(self, record):
        self._started = record
        self._view = progress.make_view(self._options.task or self._options.run)
        folder = self._options.folder / "logs"
        self._log = logs.Log(folder / "learner.log")
        seen = self._shown or 0
        for line in self._early[:seen]:
            self._log.append(line)
        for line in self._early[seen:]:
            self._on_log(line)
        # A run that was finished before needs none; they would wait for a learner that has ended.
        count = self._useful(record["episodes_per_update"]) if record["update"] < record["updates_total"] else 0
        self._actors = [Actor(i, folder / f"actor-{i}.log") for i in range(count)]
        self._view.note(
            f"run {self._options.run}: learner and {count} actor{'s' * (count != 1)}; "
            f"logs in {shown(folder)}/"
        )
        self._view.note(f"  watch       {command_line.watch_command(self._options, record)}")
        self._is_capped = 0 < count < self._options.actors
        if self._is_capped:
            self._view.note(
                f"warning: {count} of {self._options.actors} cores have an actor, since an update has no more "
                f"episodes ({record['episodes_per_update']}); a new run can use them all:\n"
                f"  {command_line.wide_command(self._options)}"
            )
        if count or not self._options.actors:
            self._patience = Patience()
        else:
            self._patience.end()
        if not self._options.actors:
            self._view.note(
                "no actor here: start them with " + command_line.join_command(self._options, record)
            )

    def _useful(self, episodes):
        """@param episodes  of an update. @return how many actors to start: those asked for, else as many as can have
        an episode to play."""
        options = self._options
        most = -(-episodes // options.envs)
        return options.actors if options.counted else min(options.actors, most)

    def _on_log(self, line):
        if not self._log:
            self._early.append(line)
            if self._shown is not None:
                self._show_early()
            return
        self._log.append(line)
        if JOINED.search(line):
            self._patience.end()
        if SERIOUS.search(line) and not (self._is_capped and IDLE.search(line)) and self._complaints < COMPLAINTS:
            self._complaints += 1
            self._view.note(line.decode(errors="surrogateescape"))
            if self._complaints == COMPLAINTS:
                self._view.note("further warnings and errors go to the learner's log alone")

    def _say_what_is_missing(self):
        waited = self._patience.runs_out()
        if waited is None:
            return
        if self._started is None:
            self._view.note(f"the learner does not serve the run after {waited:.0f} s; it says:")
            self._show_early()
            return
        folder = shown(self._options.folder / "logs")
        actors = f"{folder}/actor-*.log" if self._actors else "what the actors say elsewhere"
        self._view.note(
            f"no actor has joined after {waited:.0f} s: see {folder}/learner.log and {actors}. Causes "
            "are a --run, --domain, --transport, --network or engine other than the learner's, "
            "and firewalls (deploy/machines.md)"
        )
        for actor in self._actors[:1]:
            self._view.note(f"the last lines of {shown(actor.log)}:\n{logs.tail(actor.log, 3)}")

    def _show_early(self):
        for line in self._early[self._shown or 0 :] or [b"(nothing so far)"]:
            self._view.note("  " + line.decode(errors="surrogateescape"))
        self._shown = len(self._early)

    # Actors.

    def _tend_actors(self):
        for actor in self._actors:
            if actor.process and actor.start_at is None and actor.process.poll() is not None:
                self._on_actor_end(actor)
            if actor.start_at is not None and time.monotonic() >= actor.start_at:
                self._start(actor)
        self._failed = bool(self._actors) and all(actor.given_up for actor in self._actors)

    def _start(self, actor):
        try:
            actor.start(command_line.actor_command(self._options, actor.index, self._started))
        except OSError as error:
            self._on_failure(actor, f"actor {actor.index} could not be started: {error}")

    def _on_actor_end(self, actor):
        code, actor.process = actor.process.returncode, None
        if code != 0 and not self._stop_signal and not self._finished:
            self._on_failure(actor, f"actor {actor.index} ended with {_ending(code)}")

    def _on_failure(self, actor, what):
        if actor.starts > RESTARTS:
            actor.given_up = True
            self._view.note(
                f"{what} for the {actor.starts}th time and is given up; {shown(actor.log)}:"
            )
            self._view.note(logs.tail(actor.log))
            return
        self._view.note(f"{what}; starting it again ({shown(actor.log)}):\n{logs.tail(actor.log, 1)}")
        actor.start_later()

    def _end_actors(self):
        if self._done():
            self._events.stop(self._running(), ((0, ACTOR_FINISH),))
        self._events.stop(self._running(), ACTOR_STOP)

    def _running(self):
        return [actor.process for actor in self._actors if actor.process]

    # The end.

    def _done(self):
        return self._learner.returncode == 0 and self._finished.get("event") == "finished"

    def _report(self, code):
        options = self._options
        # A code of its own says what the learner could not do: leave a checkpoint, say.
        stopped = self._stop_signal and not 0 < code < 128
        if self._started is None and not self._stop_signal:
            for line in self._early[self._shown or 0 :]:
                print(line.decode(errors="surrogateescape"), file=sys.stderr)
            if not self._early:
                print(f"{command_line.NAME}: the learner ended with {_ending(code)}", file=sys.stderr)
            return _exit_code(code)
        if self._failed:
            print(
                f"{command_line.NAME}: no actor stays up, so the run was stopped (see above)",
                file=sys.stderr,
            )
        elif code != 0 and not stopped:
            print(
                f"{command_line.NAME}: the learner ended with {_ending(code)}; its last lines:",
                file=sys.stderr,
            )
            print(logs.tail(options.folder / "logs" / "learner.log"), file=sys.stderr)
        if self._started:
            self._say_results(self._done())
        if stopped and not self._done():
            return 128 + self._stop_signal
        return 1 if self._failed else _exit_code(code)

    def _say_results(self, done):
        options = self._options
        folder, latest = options.folder, options.folder / "checkpoints" / "latest"
        stopped = self._finished.get("message", f"stopped: run {options.run}")
        print(f"finished: {self._finished['message']}" if done else stopped)
        print(f"  results     {shown(folder)}/progress.csv")
        print(f"  curves      {shlex.join(['tensorboard', '--logdir', shown(folder)])}")
        newest = f" -> {os.readlink(latest)}" if latest.is_symlink() else ""
        print(f"  checkpoint  {shown(latest)}{newest}")
        evaluate = [typed(options.build / "bin" / "metronome-actor"), "evaluate"]
        # The one placement that the run knows.
        where = ["--placements", "fixed"] if self._started.get("placements") == "fixed" else []
        print(f"  evaluate    {shlex.join([*evaluate, '--checkpoint', shown(latest), *where])}")
        if not done:
            print(f"  go on       {command_line.resume_command(options)}")


def _ending(code):
    names = {number.value: number.name for number in signal.Signals}
    return f"signal {names.get(-code, -code)}" if code < 0 else f"exit code {code}"


def _exit_code(code):
    return code if code >= 0 else 128 - code
