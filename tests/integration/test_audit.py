"""Episodes that two hosts play: a machine that computes wrongly is found, named and sent away. Hosts are
machines with an address each, whatever they call themselves."""

import json

import pytest

import namespaces
from harness import BUILD, ENDLESS, EPISODES, UPDATES

HOSTILE = BUILD / "bin" / "hostile-actor"
REFUSED = 1

pytestmark = pytest.mark.skipif(
    namespaces.unavailable() is not None, reason=str(namespaces.unavailable())
)


@pytest.fixture(scope="module")
def expected(module_stage):
    return module_stage.train("calm")


@pytest.fixture(scope="module")
def hosts():
    with namespaces.Network() as network:
        for name in ("learner", "one", "two", "false"):
            network.host(name)
        yield network.hosts


class Site:
    """A run whose learner is on one machine and whose actors are on others."""

    def __init__(self, stage, hosts):
        self._stage, self._hosts = stage, hosts
        self.learner_address = hosts["learner"].address

    def learner(self, *options, **others):
        return self._stage.learner(
            *("run", "--network", "lan", *options), host=self._hosts["learner"], **others
        )

    def actor(self, host):
        return self._stage.actor("run", "--network", self.learner_address, host=self._hosts[host])

    def liar(self, name):
        """On the machine "false", calling it otherwise."""
        return self._stage.start(
            *(HOSTILE, "--run", "run", "--domain", self._stage.domain, "--kind", "wrong-reward"),
            *("--host", name, "--network", self.learner_address),
            host=self._hosts["false"],
        )


@pytest.fixture
def site(stage, hosts):
    return Site(stage, hosts)


def is_sent_away(liar, address):
    assert liar.wait() == REFUSED, liar
    return f"host {address} (" in liar.text and "computes wrongly" in liar.text


@pytest.mark.slow
def test_an_audited_run_has_the_same_weights_and_says_what_was_compared(stage, site, expected):
    learner = site.learner("--audit", "1")
    team = [site.actor("one"), site.actor("two")]
    assert stage.finish("run", learner, team) == expected
    learner.expect_text("in every bit")
    assert "excluded hosts: none" in learner.text


@pytest.mark.slow
def test_a_host_that_computes_wrongly_is_named_and_excluded(stage, site, hosts, expected):
    learner = site.learner("--audit", "1")
    liar = site.liar("somebody")
    learner.expect_text("actor somebody:")  # it has assignments before anybody else is there
    honest = [site.actor("one"), site.actor("two")]
    assert is_sent_away(liar, hosts["false"].address), liar
    assert stage.finish("run", learner, honest) == expected
    assert f"excluded hosts: {hosts['false'].address}" in learner.text
    assert f"{EPISODES * UPDATES} of {EPISODES * UPDATES}" in learner.text


# By name they would be two hosts that agree, against one.
@pytest.mark.slow
def test_a_machine_with_two_invented_names_does_not_outvote_an_honest_host(
    stage, site, hosts, expected
):
    learner = site.learner("--audit", "1")
    honest = [site.actor("one")]
    learner.expect_text("joins with")
    liars = [site.liar("somebody"), site.liar("somebody-else")]
    learner.expect_text("the run waits for it")  # whoever is there, they are two machines
    for name in ("somebody:", "somebody-else:"):
        learner.expect_text(f"actor {name}")
    honest.append(site.actor("two"))
    assert all([is_sent_away(liar, hosts["false"].address) for liar in liars]), liars
    assert stage.finish("run", learner, honest) == expected
    assert f"excluded hosts: {hosts['false'].address}" in learner.text
    assert list(json.loads((stage.runs / "run" / "excluded.json").read_text())) == [
        hosts["false"].address
    ]


@pytest.mark.slow
def test_an_excluded_host_stays_so_when_the_learner_starts_again(stage, site, hosts):
    learner = site.learner("--audit", "1", small=ENDLESS)
    liar = site.liar("somebody")
    learner.expect_text("actor somebody:")
    honest = [site.actor("one"), site.actor("two")]
    assert is_sent_away(liar, hosts["false"].address), liar
    learner.kill()
    again = site.learner("--resume", "--audit", "1", small=ENDLESS)
    again.expect_text("it stays excluded")
    assert is_sent_away(site.liar("never-heard-of"), hosts["false"].address)
    for process in (again, *honest):
        process.kill()


@pytest.mark.slow
def test_without_an_audit_the_same_lie_changes_the_weights(stage, site, expected):
    learner, liar = site.learner(), site.liar("somebody")
    assert learner.wait() == 0, learner
    assert stage.inspect(stage.latest("run"))["weights_sha256"] != expected
    liar.wait()
