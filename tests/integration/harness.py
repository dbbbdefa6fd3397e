"""Real learner and actor processes on loopback DDS, and deadlines instead of sleeps."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "deploy" / "launcher"))
import children  # noqa: E402  (the launcher's own: no child outlives us)

BUILD = Path(os.environ.get("METRONOME_BUILD", ROOT / "build"))
ENGINE = "3.3.0" if BUILD.name.endswith("3.3.0") else "2.2.2"
LEARNER = str(BUILD / "bin" / "metronome-learner")
ACTOR = str(BUILD / "bin" / "metronome-actor")
# Generous: it is only ever waited for in full when something is broken.
DEADLINE = 120.0

# A run of 8 updates of 4 episodes of 50 steps: a second of work.
EPISODES, HORIZON, UPDATES = 4, 50, 8
STEPS = EPISODES * HORIZON * UPDATES
SMALL = (
    "--task",
    "push",
    "--steps",
    str(STEPS),
    "--seed",
    "7",
    "--set",
    f"environment.horizon={HORIZON}",
    "--set",
    f"collection.episodes_per_update={EPISODES}",
    "--set",
    "ppo.minibatch=50",
)


def small(steps):
    """SMALL with another number of steps."""
    words = list(SMALL)
    words[words.index("--steps") + 1] = str(steps)
    return words


def updates_of(small):
    """How many updates a run of these words has."""
    return int(small[small.index("--steps") + 1]) // (EPISODES * HORIZON)


# A few seconds of work, for tests that strike in the middle of a run.
LONG = small(5 * STEPS)
LONG_UPDATES = updates_of(LONG)
ENDLESS = small(100_000_000)  # half a million updates: no test sees the last


class Process:
    """A child whose output is read as it comes."""

    def __init__(self, command, on_line=None):
        """@param on_line  called with each line, in a thread of its own."""
        self.command = [str(word) for word in command]
        self.lines = []  # of both streams, as they came
        self.output = []  # of standard output alone
        self._changed = threading.Condition()
        self._open = 2
        self._on_line = on_line or (lambda line: None)
        self.child = children.start(
            self.command,
            obeys=children.STOP_SIGNALS,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        for stream in (self.child.stdout, self.child.stderr):
            threading.Thread(target=self._read, args=(stream,), daemon=True).start()

    def _read(self, stream):
        for line in stream:
            with self._changed:
                self.lines.append(line.rstrip("\n"))
                if stream is self.child.stdout:
                    self.output.append(line)
                self._changed.notify_all()
            self._on_line(line)
        with self._changed:
            self._open -= 1
            self._changed.notify_all()

    def expect(self, matches, what, seconds=DEADLINE):
        """Blocks until a line satisfies `matches`, old ones included. @return what it returned."""
        deadline, seen = time.monotonic() + seconds, 0
        with self._changed:
            while True:
                for line in self.lines[seen:]:
                    found = matches(line)
                    if found:
                        return found
                seen = len(self.lines)
                left = deadline - time.monotonic()
                if self._open == 0 or left <= 0:
                    raise AssertionError(f"{what}: not said by {self}")
                self._changed.wait(left)

    def expect_text(self, text, seconds=DEADLINE):
        return self.expect(
            lambda line: line if text.lower() in line.lower() else None, f"'{text}'", seconds
        )

    def expect_event(self, name):
        return self.expect(
            lambda line: parse_json(line) if parse_json(line).get("event") == name else None, f"event {name}"
        )

    def updates(self):
        """@return how many updates the learner has told of so far."""
        with self._changed:
            told = [parse_json(line) for line in self.lines]
        return max((said["update"] for said in told if "update" in said), default=0)

    def expect_update(self, number, seconds=DEADLINE):
        """Waits for the learner's word that `number` updates or more are done."""
        return self.expect(
            lambda line: parse_json(line)
            if parse_json(line).get("update", -1) >= number and "event" not in parse_json(line)
            else None,
            f"update {number}",
            seconds,
        )

    def wait(self, seconds=DEADLINE):
        """@return the exit code, once all output is read."""
        try:
            code = self.child.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"did not end within {seconds} s: {self}") from None
        with self._changed:
            self._changed.wait_for(lambda: self._open == 0, 10)
        return code

    def signal(self, number):
        self.child.send_signal(number)

    def kill(self):
        self.signal(signal.SIGKILL)
        self.child.wait()

    def json(self):
        """Standard output as one JSON object."""
        return json.loads("".join(self.output))

    @property
    def text(self):
        return "\n".join(self.lines)

    def __str__(self):
        return self._head() + self.text

    def ending(self, lines=30):
        """As __str__, with the last lines alone."""
        return self._head() + "\n".join(self.lines[-lines:])

    def _head(self):
        return f"{' '.join(self.command)}\nexit code {self.child.poll()}\n"


def parse_json(line):
    if not line.startswith("{"):
        return {}
    try:
        return json.loads(line)
    except ValueError:
        return {}


def _claim_domain(name):
    """A DDS domain that no other test of this machine uses: tests of several checkouts and builds
    may run at once, and their runs have equal names. The claim is an abstract socket, which all
    processes see that share these tests' network, and which ends with its process.
    """
    first = zlib.crc32(name.encode())
    for attempt in range(100):
        domain = 1 + (first + attempt) % 100
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0metronome-test-domain-{domain}")
            return domain, claim
        except OSError:
            claim.close()
    raise AssertionError("all of the 100 DDS domains for tests are in use")


class Stage:
    """The processes of one test: their domain, their folder of runs, and their end."""

    def __init__(self, name, folder):
        self.domain, self._claim = _claim_domain(f"{os.getpid()} {name}")
        self.runs = folder / "runs"
        self.processes = []
        self.learner_program = LEARNER
        self.callbacks = []  # called by close() for what else a test leaves

    def start(self, *command, host=None):
        """@param host  of namespaces.py, to run there; None: this machine."""
        process = Process(host.process(*command) if host else command)
        self.processes.append(process)
        return process

    def learner(self, run, *options, small=SMALL, runs=None, host=None):
        return self.start(
            self.learner_program,
            "run",
            "--run",
            run,
            "--runs",
            runs or self.runs,
            "--domain",
            self.domain,
            "--progress",
            "json",
            *small,
            *options,
            host=host,
        )

    def actor(self, run, *options, host=None):
        return self.start(
            ACTOR, "run", "--run", run, "--domain", self.domain, *options, host=host
        )

    def status(self, run, *options, host=None):
        return self.start(
            LEARNER, "status", run, "--domain", self.domain, "--json", *options, host=host
        )

    def train(self, run, *options, actors=1, actor_options=(), small=SMALL):
        """A whole run: a learner and actors, each expected to end well. @return weights_sha256."""
        learner = self.learner(run, *options, small=small)
        team = [self.actor(run, *actor_options) for _ in range(actors)]
        return self.finish(run, learner, team, updates_of(small))

    def finish(self, run, learner, team, updates=UPDATES):
        """Waits for the end of a run. @return weights_sha256 of its last checkpoint."""
        assert learner.wait() == 0, learner
        for actor in team:
            assert actor.wait() == 0, actor
        state = self.inspect(self.latest(run))
        assert (state["version"], state["steps"]) == (updates, updates * EPISODES * HORIZON)
        return state["weights_sha256"]

    def latest(self, run):
        return self.runs / run / "checkpoints" / "latest"

    def inspect(self, checkpoint):
        inspect = self.start(LEARNER, "inspect", checkpoint, "--json")
        assert inspect.wait() == 0, inspect
        return inspect.json()

    def close(self):
        for callback in self.callbacks:
            callback()
        for process in self.processes:
            if process.child.poll() is None:
                process.kill()
        # Killed processes leave shared memory; the runs of a test are not gone on with.
        for note in Path("/dev/shm").glob(f"metronome-{self.domain}-*"):
            for name in note.read_text().split():
                (note.parent / name).unlink(missing_ok=True)
            note.unlink(missing_ok=True)
        self._claim.close()
        for process in self.processes:  # pytest shows it if the test failed
            print(process.ending())
        found = [str(process) for process in self.processes if "Sanitizer:" in process.text]
        assert not found, "\n\n".join(found)
