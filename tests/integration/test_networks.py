"""Actors on other machines find the learner where there is no multicast."""

import pytest

from namespaces import Network


@pytest.fixture(scope="module")
def expected(module_stage):
    """weights_sha256 of the run on loopback."""
    return module_stage.train("loopback")


@pytest.fixture
def network():
    try:
        network = Network().__enter__()
    except OSError as refused:
        pytest.skip(f"network namespaces need root: {refused}")
    yield network
    network.close()


def test_actors_of_two_other_machines_join_by_the_learners_address(network, stage, expected):
    learner_host, hosts = network.host("learner"), [network.host("a"), network.host("b")]
    learner = stage.learner("run", "--network", "lan", host=learner_host)
    team = [
        stage.actor("run", "--network", learner_host.address, "--wait", "30", host=host)
        for host in hosts
    ]
    assert stage.finish("run", learner, team) == expected


def test_an_actor_of_another_subnet_is_not_found_by_multicast(network, stage):
    learner = stage.learner("run", "--network", "lan", host=network.host("learner"))
    learner.expect_event("started")
    actor = stage.actor("run", "--network", "lan", "--wait", "5", host=network.host("a"))
    assert actor.wait(60) == 3, actor
