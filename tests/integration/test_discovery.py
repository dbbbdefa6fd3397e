"""Links that fail in one direction: who is lost is found again, whoever noticed the loss."""

import pytest

import namespaces
from harness import ACTOR, ENDLESS, LEARNER, SMALL

pytestmark = pytest.mark.skipif(
    namespaces.unavailable() is not None, reason=str(namespaces.unavailable())
)


@pytest.fixture
def network():
    with namespaces.Network() as made:
        yield made


def test_a_learner_that_starts_before_its_network_says_so(stage, network):
    here = network.host("learner", plug_in=False)
    learner = stage.start(
        *here.process(LEARNER, "run", "--run", "run", "--runs", stage.runs, *SMALL),
        *("--network", "lan"),
    )
    learner.expect_text("no interface to a network is up")
    assert "loopback interface" not in learner.text, learner


def test_a_learner_on_a_network_says_that_loopback_is_down(stage, network):
    here = network.host("learner")
    here.run("ip", "link", "set", "lo", "down")
    learner = stage.learner("run", "--network", "lan", host=here)
    learner.expect_text("the loopback interface is down: processes of this machine do not reach")
    learner.expect_event("started")
    assert "no interface to a network" not in learner.text, learner


@pytest.mark.parametrize("direction", ["to", "from", "both"])
@pytest.mark.slow
def test_an_actor_cut_off_in_any_direction_plays_on_when_the_link_is_back(
    stage, network, direction
):
    here, there = network.host("learner"), network.host("actor")
    learner = stage.start(
        *here.process(LEARNER, "run", "--run", "run", "--runs", stage.runs, *ENDLESS),
        *("--progress", "json", "--network", "lan"),
    )
    actor = stage.start(
        *there.process(ACTOR, "run", "--run", "run", "--network", here.address),
    )
    learner.expect_update(1)
    cut = there.drop(1.0, direction)
    if direction != "from":
        actor.expect_text("is gone: waiting for its return (3 s", seconds=15)
    if direction != "to":
        learner.expect_text("is gone", seconds=10)
    there.stop_dropping(cut)
    if direction != "from":
        actor.expect_text("the learner is back", seconds=15)
    learner.expect_update(learner.updates() + 5, seconds=15)


@pytest.mark.parametrize("transport", ["udp", "shm", "tcp"])
def test_a_loopback_interface_that_is_down_is_named_with_the_remedy(stage, network, transport):
    here = network.host("here")
    here.run("ip", "link", "set", "lo", "down")
    way = ("--transport", transport)
    for process in (
        stage.learner("run", *way, host=here),
        stage.actor("run", *way, host=here),
        stage.status("run", *way, host=here),
    ):
        assert process.wait(20) == 2, process
        assert "the loopback interface is down" in process.text, process
        assert "ip link set lo up" in process.text, process
    assert not (stage.runs / "run").exists()
