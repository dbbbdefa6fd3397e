"""Costs of actors for a learner besides their episodes: being there, joining, each new version of the
weights; and how unlike each other the durations of episodes are. deploy/growth reckons with it.

Everything runs in a network namespace of its own (as root), whose datagrams nftables counts.
"""

import contextlib
import json
import os
import pathlib
import statistics
import sys
import time

from suite import _stats, _train, _wire

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "integration"))
import namespaces  # noqa: E402  (its path comes first)

NAME = "crowd"
HELP = "what connected, joining and listening actors cost the learner; how durations of episodes vary"
CROWDS = (1, 16, 64)
# Nothing but messages of presence for this long, while one long update runs.
WINDOW_SECONDS, SETTLING_SECONDS = 10, 4
UPDATES = 200
BATCH = 1024
ACTORS_USER = 65534  # actors' datagrams are known by it


def measure(options, record):
    if (reason := namespaces.unavailable()) is not None:
        sys.exit(f"crowd: {reason}")
    crowds = CROWDS[:2] if options.quick else CROWDS
    for number in range(1, options.rounds + 1):
        def put(case, quantity, unit, value):
            record(case=case, quantity=quantity, unit=unit, round=number, value=value)

        for actors in crowds:
            _presence(options, actors, put)
            _versions(options, actors, put)
            _assignments(options, actors, put)
        for task in options.tasks:
            _durations(options, task, put)


def _settings(options, *more, task=None, steps=10**6):
    return ["--task", task or options.tasks[0], "--steps", steps, "--seed", 7,
            "--set", "collection.episodes_per_update=1", "--set", "ppo.minibatch=500",
            "--set", "ppo.kl_stop=0", "--set", "runtime.learner_threads=1", *more]


@contextlib.contextmanager
def _place(options):
    """A stage whose processes start in a namespace, and that namespace with its counters."""
    with _wire.stage(options, NAME) as stage:
        space = namespaces.Namespace(f"metronome-crowd-{os.getpid()}")
        start = stage.start
        stage.start = lambda *command: start(*space.command(*_as_user(*command)))
        stage.folder.chmod(0o755)
        try:
            _count_datagrams(space, 7400 + 250 * stage.domain)
            yield stage, space
        finally:
            stage.close()
            space.close()


def _as_user(program, command, *words):
    """Actors have another user than the learner."""
    user = ["setpriv", f"--reuid={ACTORS_USER}", "--clear-groups"] if program.name == "swarm" else []
    return [*user, program, command, *words]


def _count_datagrams(space, base):
    """The traffic between learner and actors; the rest (`search`) is multicast and goes to the ports
    where other learners of this machine would be (idl/README.md), whoever sends it."""
    search = ", ".join(str(base + port) for port in (0, *range(12, 42, 2)))
    rules = "; ".join(f'{what} counter accept comment "{direction}"' for direction, what in (
        ("search", f"udp dport {{ {search} }}"), ("to_learner", f"meta l4proto udp meta skuid {ACTORS_USER}"),
        ("to_actors", "meta l4proto udp")))
    space.run("nft", f"table inet crowd {{ chain out {{ type filter hook output priority 0; {rules}; }}; }}")


def _datagrams(space):
    """{direction: (packets, bytes)} so far; bytes with the headers of IP and UDP."""
    listing = json.loads(space.run("nft", "-j", "list", "table", "inet", "crowd"))
    found = {}
    for entry in listing["nftables"]:
        for part in entry.get("rule", {}).get("expr", []):
            if "counter" in part:
                found[entry["rule"]["comment"]] = (part["counter"]["packets"], part["counter"]["bytes"])
    return found


def _thread_seconds(pid):
    """{thread: processor seconds so far} of a process."""
    seconds = {}
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(OSError):  # a thread that ends
            seconds[task.name] = int((task / "schedstat").read_text().split()[0]) / 1e9
    return seconds


def _children(pid):
    return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


class _Sample:
    """Processor time and datagrams at one moment."""

    def __init__(self, learner, swarm, space):
        self.time = time.monotonic()
        self.learner = _thread_seconds(learner.child.pid)
        self.actors = sum(sum(_thread_seconds(child).values()) for child in _children(swarm.child.pid))
        self.datagrams = _datagrams(space)


def _presence(options, actors, put):
    """One update of a minute, so that actors and learner only tell each other that they live."""
    settings = _settings(options, "--set", "ppo.epochs=10000", "--set", "ppo.minibatch=20")
    with _place(options) as (stage, space):
        config = _wire.config_file(stage, *settings)
        swarm = _wire.swarm(stage, "actors", config, "udp", "--actors", actors, "--prepared", 0)
        swarm.expect_text("ready", _wire.PATIENCE)
        learner = _wire.learner(stage, "udp", *settings)
        learner.expect(lambda _: learner.text.count(" joins with ") >= actors, "all there", _wire.PATIENCE)
        joined = _Sample(learner, swarm, space)
        time.sleep(SETTLING_SECONDS)
        first = _Sample(learner, swarm, space)
        time.sleep(WINDOW_SECONDS)
        last = _Sample(learner, swarm, space)
    case, seconds = f"{actors} actors", last.time - first.time
    spent = {thread: last.learner[thread] - first.learner.get(thread, 0) for thread in last.learner}
    spent.pop(max(spent, key=spent.get))  # the one that learns
    put(case, "presence, learner", "ms CPU a second", 1e3 * sum(spent.values()) / seconds)
    put(case, "presence, actors", "ms CPU a second", 1e3 * (last.actors - first.actors) / seconds)
    for direction, (packets, octets) in last.datagrams.items():
        then = first.datagrams[direction]
        put(case, f"presence, datagrams {direction}", "1/s", (packets - then[0]) / seconds)
        put(case, f"presence, bytes {direction}", "B/s", (octets - then[1]) / seconds)
    joining = sum(seconds for thread, seconds in joined.learner.items() if thread in spent)
    put(case, "start and joining, learner", "ms CPU", 1e3 * joining)
    for direction, (packets, octets) in first.datagrams.items():
        put(case, f"start and joining, datagrams {direction}", "", packets)
        put(case, f"start and joining, bytes {direction}", "B", octets)


def _versions(options, actors, put):
    """One episode an update, so that new weights go out to everybody all the time."""
    settings = _settings(options, "--set", "ppo.epochs=1", steps=500 * UPDATES)
    with _place(options) as (stage, space):
        config = _wire.config_file(stage, *settings)
        swarm = _wire.swarm(stage, "actors", config, "udp", "--actors", actors, "--prepared", 0)
        swarm.expect_text("ready", _wire.PATIENCE)
        learner = _wire.learner(stage, "udp", *settings)
        learner.expect(lambda _: learner.text.count(" joins with ") >= actors, "all there", _wire.PATIENCE)
        first, begin = _Sample(learner, swarm, space), learner.updates()
        learner.expect_update(UPDATES - 10, _wire.PATIENCE)
        last, end = _Sample(learner, swarm, space), learner.updates()
    case, updates = f"{actors} actors", end - begin
    spent = sum(last.learner.values()) - sum(first.learner.get(thread, 0) for thread in last.learner)
    put(case, "version, learner", "ms CPU an update", 1e3 * spent / updates)
    put(case, "version, seconds", "s an update", (last.time - first.time) / updates)
    octets = last.datagrams["to_actors"][1] - first.datagrams["to_actors"][1]
    put(case, "version, bytes to_actors", "B an update", octets / updates)


def _assignments(options, actors, put):
    """One batch whose episodes are ready before the learner starts: what one of them costs it, all told."""
    settings = _settings(options, "--set", "ppo.epochs=1", "--set", f"collection.episodes_per_update={BATCH}",
                         steps=500 * BATCH)
    with _place(options) as (stage, space):
        config = _wire.config_file(stage, *settings)
        swarm = _wire.swarm(stage, "actors", config, "udp", "--actors", actors, "--prepared", BATCH)
        swarm.expect_text("ready", _wire.PATIENCE)
        learner = _wire.learner(stage, "udp", *settings)
        assert learner.wait(_wire.PATIENCE) == 0, learner
        said = learner.text.split(" CPU seconds: ")[1].splitlines()[0]
        uses = {use: float(seconds) for use, seconds in _train.USES.findall(said)}
        sent = _datagrams(space)
    case = f"{actors} actors"
    put(case, "episode, check", "ms CPU", 1e3 * uses["check"] / BATCH)
    put(case, "episode, wire", "ms CPU", 1e3 * (uses["rest"] + uses.get("send", 0)) / BATCH)
    for direction in ("to_actors", "to_learner"):
        put(case, f"episode, datagrams {direction}", "1", sent[direction][0] / BATCH)


def _durations(options, task, put):
    """Processor time of a real actor from one episode to the next, untrained policy."""
    settings = _settings(options, "--set", "ppo.epochs=1", "--set", "ppo.learning_rate=1e-9", task=task,
                         steps=500 * (20 if options.quick else 120))
    with _wire.stage(options, NAME) as stage:
        learner = _wire.learner(stage, "udp", *settings)
        actor = stage.start(stage.bin / "metronome-actor", "run", "--run", "swarm", "--domain", stage.domain)
        seconds, at = [], None
        for update in range(1, 20 if options.quick else 120):
            learner.expect_update(update, _wire.PATIENCE)
            now = sum(_thread_seconds(actor.child.pid).values())
            # Updates that were told of together cannot be told apart.
            if at is not None and learner.updates() == update == at[0] + 1:
                seconds.append(now - at[1])
            at = (update, now)
    case = f"{task} played"
    put(case, "episode", "ms CPU", 1e3 * statistics.median(seconds))
    put(case, "variation", "of the mean", statistics.stdev(seconds) / statistics.mean(seconds))


def table(rows):
    medians = _stats.medians(rows)
    crowds = {case: of for case, of in medians.items() if "version, learner" in of}
    columns = ["presence, learner", "presence, actors", "presence, bytes to_learner", "presence, bytes to_actors",
               "start and joining, learner", "version, learner", "version, bytes to_actors", "episode, wire", "episode, check"]
    scales = [1, 1, 1e-3, 1e-3, 1, 1, 1e-3, 1, 1]
    lines = [[case, *(f"{of[name] * scale:.2f}" for name, scale in zip(columns, scales))]
             for case, of in crowds.items()]
    played = [[case, f"{of['episode']:.1f}", f"{of['variation']:.3f}"]
              for case, of in medians.items() if "variation" in of]
    return "\n\n".join([
        "Connected, idle actor processes (`presence`): processor time of the learner and of all actors, ms a second,"
        " and kB a second between them. The learner's processor time, ms, from its start until all had joined, and"
        " for one whole update of one episode (2x128), whose weights go to all, with the kB sent to them;"
        f" for one episode of a batch of {BATCH} that is there at once, without and in its check:",
        _stats.markdown(["", "learner", "actors", "to learner", "to actors", "joining", "update", "sent", "episode", "check"],
                        lines),
        "Processor time of one episode of 500 steps, ms, and its standard deviation over its mean:",
        _stats.markdown(["", "ms", "variation"], played),
    ])
