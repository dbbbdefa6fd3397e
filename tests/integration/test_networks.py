"""Actors on other machines, where there is no multicast: they find the learner by its address, by a
Discovery Server, or over TCP."""

import contextlib
import signal

import pytest

import namespaces
from harness import BUILD, ENDLESS, EPISODES, HORIZON, parse_json, small

pytestmark = pytest.mark.skipif(
    namespaces.unavailable() is not None, reason=str(namespaces.unavailable())
)
WAYS = ("address", "discovery-server", "tcp")
LEASE = 5.0  # seconds: 2.5, and what a machine that is full takes to tell
AT_ONCE = 9.0  # seconds: less than the 10 after which an actor looks anew by itself


def of_updates(updates):
    return small(EPISODES * HORIZON * updates)


LONG = 30


@pytest.fixture(scope="module")
def expected(module_stage):
    """weights_sha256 of the run on loopback, by number of updates."""
    return {
        8: module_stage.train("short"),
        LONG: module_stage.finish(
            "long",
            module_stage.learner("long", small=of_updates(LONG)),
            [module_stage.actor("long")],
            LONG,
        ),
    }


@pytest.fixture(scope="module")
def network():
    with namespaces.Network() as made:
        for name in ("learner", "server", "a", "b"):
            made.host(name)
        yield made


class Way:
    """How the processes of a run find each other: options of the learner and of all others."""

    def __init__(self, name, stage, hosts):
        self.name, self._stage, self._hosts = name, stage, hosts
        learner = hosts["learner"].address
        self.learner = self.others = {
            "address": ("--network", learner),
            "discovery-server": (
                *("--network", "lan", "--discovery-server", hosts["server"].address),
            ),
            "tcp": ("--transport", "tcp", "--network", learner),
        }[name]
        if name == "address":
            self.learner = ("--network", "lan")
        if name == "discovery-server":
            self.start_server()

    def start_server(self):
        self.server = self._stage.start("fast-discovery-server", "-i", "0", host=self._hosts["server"])
        self.server.expect_text("server is running")


@pytest.fixture(params=WAYS)
def way(request, stage, network):
    return Way(request.param, stage, network.hosts)


@pytest.fixture
def server_way(stage, network):
    return Way("discovery-server", stage, network.hosts)


@contextlib.contextmanager
def firewall(network, domain, way):
    """Lets the ports of deploy/machines.md through and no others."""
    base = 7400 + 250 * domain
    learner, server, actor = (network.hosts[name].port for name in ("learner", "server", "a"))
    if way == "tcp":
        open_ports = [
            f'oifname "{learner}" tcp dport {base + 10} accept',
            f'iifname "{learner}" tcp sport {base + 10} ct state established accept',
        ]
    else:
        open_ports = [
            f'oifname "{learner}" udp dport {{ {base + 10}, {base + 11} }} accept',
            f'oifname "{actor}" udp dport {{ {base + 42}, {base + 11} }} accept',
            f'oifname "{server}" udp dport 11811 accept',
        ]
    chain = ["chain pass {", "type filter hook forward priority 0; policy drop", *open_ports, "}"]
    network.router.run("nft", "\n".join(["table ip firewall {", *chain, "}"]))
    try:
        yield
    finally:
        network.router.run("nft", "delete", "table", "ip", "firewall")


@pytest.mark.slow
def test_through_the_documented_ports_alone_a_run_gives_the_weights_of_loopback(
    stage, network, way, expected
):
    with firewall(network, stage.domain, way.name):
        learner = stage.learner("run", *way.learner, host=network.hosts["learner"])
        actor = stage.actor("run", *way.others, host=network.hosts["a"])
        assert stage.finish("run", learner, [actor]) == expected[8]


@pytest.mark.parametrize("way", WAYS[1:], indirect=True)
@pytest.mark.slow
def test_many_join_are_seen_and_are_missed_when_killed(stage, network, way):
    learner = stage.learner("seen", *way.learner, small=ENDLESS, host=network.hosts["learner"])
    learner.expect_event("started")
    # Several of one machine: over TCP their connections differ by their process alone.
    team = [stage.actor("seen", *way.others, host=network.hosts[name]) for name in "aabbabab"]
    status = stage.status("seen", "--follow", *way.others, host=network.hosts["server"])
    for actor in team:
        actor.expect_text("joined run", seconds=AT_ONCE)
    status.expect(lambda line: parse_json(line).get("envs_total") == 8, "eight actors", 20)
    if way.name == "discovery-server":  # a lost peer is missed without it too
        way.server.kill()
        learner.expect_text("the discovery server at", seconds=20)
    team[0].kill()
    learner.expect_text(f"{team[0].child.pid} is gone", seconds=LEASE)
    learner.expect_update(learner.updates() + 5, seconds=20)
    learner.signal(signal.SIGINT)
    assert learner.wait(20) == 130, learner
    assert status.wait(10) == 0, status


@pytest.mark.slow
def test_the_learner_says_how_to_join_by_each_way(stage, network):
    host = network.hosts["learner"]
    ways = {name: Way(name, stage, network.hosts) for name in WAYS}
    learners = {name: stage.learner(name, *ways[name].learner, host=host) for name in WAYS}
    for name, learner in learners.items():
        said = learner.expect_text("start one with: metronome-actor run", seconds=20)
        assert said.endswith(" ".join(ways[name].learner)), said
    named = stage.learner("named", "--network", network.hosts["a"].address, host=host)
    said = named.expect_text("start one with: metronome-actor run", seconds=20)
    assert said.endswith("--network <address of learner>"), said


@pytest.mark.slow
def test_a_discovery_server_restarted_at_once_costs_no_episode(
    stage, network, server_way, expected
):
    learner = stage.learner(
        "run", *server_way.learner, small=of_updates(LONG), host=network.hosts["learner"]
    )
    old = stage.actor("run", *server_way.others, host=network.hosts["a"])
    learner.expect_update(2)
    server_way.server.kill()
    # What is left by the time it is back must not be taken for what is new.
    old.kill()
    server_way.start_server()
    new = stage.actor("run", *server_way.others, host=network.hosts["b"])
    new.expect_text("joined run", seconds=AT_ONCE)
    assert stage.finish("run", learner, [new], LONG) == expected[LONG]
    all_once = f"every episode number entered exactly one update: {LONG * EPISODES} of"
    assert all_once in learner.text, learner


@pytest.mark.slow
def test_while_the_discovery_server_is_away_only_newcomers_wait(
    stage, network, server_way, expected
):
    hosts, others = network.hosts, server_way.others
    learning = {"small": of_updates(LONG), "host": hosts["learner"]}
    learner = stage.learner("run", *server_way.learner, **learning)
    team = [stage.actor("run", *others, host=hosts[name]) for name in "ab"]
    for actor in team:
        actor.expect_text("joined run")
    server_way.server.kill()
    learner.expect_update(learner.updates() + 3, seconds=20)
    learner.kill()
    for actor in team:
        actor.expect_text("is gone", seconds=LEASE)
    team[0].kill()
    again = stage.learner("run", "--resume", *server_way.learner, **learning)
    again.expect_event("started")
    newcomer = stage.actor("run", *others, host=hosts["a"])
    newcomer.expect_text("no learner", seconds=20)
    server_way.start_server()
    newcomer.expect_text("joined run", seconds=20)
    assert stage.finish("run", again, [team[1], newcomer], LONG) == expected[LONG]


def test_over_tcp_nothing_is_needed_towards_the_actors(stage, network):
    """They sit behind an address translator, and whoever would connect to them is turned away."""
    way = Way("tcp", stage, network.hosts)
    router, inside = network.router, [network.hosts[name] for name in "ab"]
    ports = ", ".join(f'"{host.port}"' for host in inside)
    outside = network.hosts["learner"].port
    router.run(
        "nft",
        "table ip nat {\nchain out { type nat hook postrouting priority 100; "
        f'oifname "{outside}" masquerade; }}\n'
        "chain in { type filter hook forward priority 0; "
        f'iifname "{outside}" oifname {{ {ports} }} ct state new counter drop; }}\n}}',
    )
    try:
        learner = stage.learner("run", *way.learner, small=ENDLESS, host=network.hosts["learner"])
        for actor in [stage.actor("run", *way.others, host=host) for host in inside]:
            actor.expect_text("joined run", seconds=20)
            learner.expect_text(f":{actor.child.pid} joins", seconds=20)
        learner.expect_update(learner.updates() + 10, seconds=20)
        rules = router.run("nft", "list", "table", "ip", "nat")
        assert "counter packets 0 " in rules, f"somebody tried to connect: {rules}"
    finally:
        router.run("nft", "delete", "table", "ip", "nat")


class Preloaded:
    """Processes before whose Fast DDS stands a library of this folder."""

    def __init__(self, library):
        self.library = BUILD / "tests" / "integration" / f"lib{library}.so"

    def process(self, *command):
        return ("env", f"LD_PRELOAD={self.library}", *command)


@pytest.mark.slow
def test_over_tcp_a_learner_that_answers_at_once_is_heard(stage):
    loopback = ("--transport", "tcp")
    learner = stage.learner("run", *loopback, small=ENDLESS)
    learner.expect_event("started")
    # Their first connecting thread is held up until the learner has answered.
    held_up = Preloaded("late_port")
    actor = stage.actor("run", *loopback, host=held_up)
    status = stage.status("run", *loopback, host=held_up)
    for process in (actor, status):
        process.expect_text("held up between connecting and noting the port")
    actor.expect_text("joined run", seconds=AT_ONCE)
    assert status.wait(AT_ONCE) == 0, status


def test_over_tcp_a_learner_that_ends_has_no_connections_left(stage):
    loopback = ("--transport", "tcp")
    learner = stage.learner("run", *loopback, small=ENDLESS, host=Preloaded("connections_left"))
    learner.expect_event("started")
    team = [stage.actor("run", *loopback) for _ in range(3)]
    for actor in team:
        actor.expect_text("joined run")
    learner.signal(signal.SIGINT)
    assert learner.wait(20) == 130, learner
    counts = {line for line in learner.lines if line.startswith("connections at the end")}
    assert counts == {"connections at the end: 0"}, learner
    for actor in team:
        actor.expect_text("is gone", seconds=LEASE)


@pytest.mark.slow
def test_over_tcp_an_actor_that_is_cut_off_holds_nobody_up(stage, network):
    """Snapshots of 1.2 MB fill what the system takes for a peer that does not answer."""
    way = Way("tcp", stage, network.hosts)
    large = (*ENDLESS, "--set", "policy.hidden=512,512", "--set", "ppo.epochs=1")
    learner = stage.learner("run", *way.learner, small=large, host=network.hosts["learner"])
    team = [stage.actor("run", *way.others, host=network.hosts[name]) for name in "ab"]
    for actor in team:
        actor.expect_text("joined run")
    learner.expect_update(1)
    network.hosts["a"].set_link("down")
    try:
        learner.expect_text(f"{team[0].child.pid} is gone", seconds=15)
        learner.expect_update(learner.updates() + 3, seconds=20)
    finally:
        network.hosts["a"].set_link("up")
    team[0].expect_text("the learner is back", seconds=30)


def test_a_tcp_port_in_use_is_named_with_the_remedy(stage, network):
    way = Way("tcp", stage, network.hosts)
    first = stage.learner("run", *way.learner, host=network.hosts["learner"])
    first.expect_event("started")
    second = stage.learner("other", *way.learner, host=network.hosts["learner"])
    assert second.wait(20) == 1, second
    for words in (f"TCP port {7410 + 250 * stage.domain}", "--network HOST:PORT"):
        assert words in second.text, second


def test_an_actor_of_another_subnet_is_not_found_by_multicast(stage, network):
    learner = stage.learner("run", "--network", "lan", host=network.hosts["learner"])
    learner.expect_event("started")
    actor = stage.actor("run", "--network", "lan", "--wait", "1", host=network.hosts["a"])
    assert actor.wait(20) == 3, actor
