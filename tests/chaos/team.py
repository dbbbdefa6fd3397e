"""A learner and its actors, each on a machine of its own, and who of them is meant to be there."""

import contextlib
import json
import queue
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "integration"))
import harness  # noqa: E402
import namespaces  # noqa: E402

RUN = "chaos"
EPISODES, HORIZON, UPDATES = 8, 100, 200
TRAINING = (
    *("--task", "push", "--seed", "7", "--steps", str(EPISODES * HORIZON * UPDATES)),
    *("--set", f"environment.horizon={HORIZON}"),
    *("--set", f"collection.episodes_per_update={EPISODES}", "--set", "ppo.minibatch=200"),
)
HOSTILE = str(harness.BUILD / "bin" / "hostile-actor")
RELAY = str(Path(__file__).with_name("relay.py"))
RESTARTABLE = 4, 1  # a rival that lives no more is still seen; a disk that is full


class Failed(Exception):
    """A run did what it must never do."""


@contextlib.contextmanager
def small_disk(folder, size):
    """A new file system at `folder`, so small that it can be filled. @param size  e.g. "48m"."""
    folder.mkdir(parents=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


class Team:
    """@param folder    of the run's folder; removed first.
    @param options   more of the learner's.
    @param training  the options that decide what is learnt."""

    def __init__(self, folder, actors=3, options=(), training=TRAINING, domain=0):
        self.folder, self.options, self.domain = Path(folder), tuple(options), domain
        self.training = tuple(training)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.events = queue.Queue()  # ("update", n, when), ("said", line)
        self.network = namespaces.Network()
        self.learner_host = self.network.host("learner")
        self.actor_hosts = [f"actor{i + 1}" for i in range(actors)]
        for name in self.actor_hosts[:-1]:
            self.network.host(name)
        self.bad_wire = self._wire(self.network.host(self.actor_hosts[-1], plug_in=False))
        self.learner = None
        self.actors = {}
        self.all = []  # every process ever started
        self.done = None  # the learner's last words: its `finished` event

    def host(self, name):
        return self.network.hosts[name]

    def _wire(self, host):
        relay = subprocess.Popen(
            [sys.executable, "-B", RELAY, host.name, self.network.router.name, host.port],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        relay.stdout.readline()
        host.configure()
        return relay

    def set_wire(self, condition):
        """@return what the wire of the last actor did to packets under the condition before."""
        self.bad_wire.stdin.write(json.dumps(condition) + "\n")
        self.bad_wire.stdin.flush()
        return json.loads(self.bad_wire.stdout.readline())

    def start_learner(self):
        resume = ["--resume"] if (self.folder / RUN / "checkpoints").exists() else []
        self.learner = self._start(
            self.learner_host,
            *(harness.LEARNER, "run", "--run", RUN, "--runs", self.folder, "--progress", "json"),
            *("--domain", self.domain, "--network", "lan", *self.training, *self.options, *resume),
            on_line=self._hear,
        )

    def start_actor(self, name):
        self.actors[name] = self._start(
            self.host(name),
            *(harness.ACTOR, "run", "--run", RUN, "--domain", self.domain),
            *("--network", self.learner_host.address),
        )

    def start_hostile(self, name, kind):
        return self._start(
            self.host(name),
            *(HOSTILE, "--run", RUN, "--domain", self.domain, "--kind", kind),
            *("--network", self.learner_host.address),
        )

    def _start(self, host, *command, on_line=None):
        process = harness.Process(host.process(*command), on_line)
        process.name = f"{host.host_name}-{Path(command[0]).name}"
        self.all.append(process)
        return process

    def _hear(self, line):
        said = harness.parse_json(line)
        if said.get("event") == "finished":
            self.done = said
        if "update" in said and "event" not in said:
            self.events.put(("update", said["update"], time.monotonic()))
        else:
            self.events.put(("said", line, time.monotonic()))

    def waits(self, name):
        """@return for how many seconds the actor has been without a learner, as it says."""
        lines = self.actors[name].lines
        said = re.search(r"(no learner for|is gone: waiting).*\((\d+) s", lines[-1] if lines else "")
        return float(said[2]) if said else 0.0

    def check(self, learner_expected, actors_expected):
        """Restarts a learner that ended for a reason that passes; raises Failed for any other end.
        @param learner_expected, actors_expected  who of them is meant to be there."""
        code = self.learner.child.poll() if learner_expected else None
        if code is not None and code != 0:
            if code not in RESTARTABLE:
                raise Failed(f"the learner ended: {self.learner}")
            self.start_learner()
        for name in actors_expected:
            if self.actors[name].child.poll() not in (None, 0):
                raise Failed(f"{name} ended: {self.actors[name]}")

    def finish(self):
        """After the learner's last update. @return weights_sha256."""
        if self.learner.wait(60) != 0:
            raise Failed(f"the learner did not end well: {self.learner}")
        for name, actor in self.actors.items():
            self._expect_end(name, actor)
        return self.done["weights_sha256"]

    def _expect_end(self, name, actor):
        try:
            if actor.wait(10) == 0:
                return
        except AssertionError:  # it lives
            # Who was cut off when the run ended has not heard of it, and says what it waits for.
            if self.waits(name) > 0:
                actor.signal(signal.SIGTERM)
                if actor.wait(10) == 128 + signal.SIGTERM:
                    return
        raise Failed(f"{name} did not end well: {actor}")

    def write_logs(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        for number, process in enumerate(self.all):
            (folder / f"{number:02}-{process.name}.log").write_text(f"{process}\n")

    def close(self):
        for process in self.all:
            if process.child.poll() is None:
                process.signal(signal.SIGCONT)
                process.kill()
        self.bad_wire.kill()
        self.bad_wire.wait()
        self.network.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
