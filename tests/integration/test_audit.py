"""Episodes that two hosts play: a machine that computes wrongly is found, named and sent away."""

import os

import pytest

from harness import BUILD, ENDLESS, EPISODES, UPDATES

HOSTILE = BUILD / "bin" / "hostile-actor"
REFUSED = 1

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="another host's name needs root")


@pytest.fixture(scope="module")
def expected(module_stage):
    return module_stage.train("calm")


class Named:
    """This machine, called otherwise: a `host` to Stage."""

    def __init__(self, name):
        self._name = name

    def process(self, *command):
        change = ("unshare", "--uts", "sh", "-c", 'hostname "$1"; shift; exec "$@"', "sh")
        return (*change, self._name, *command)


def actor_on(stage, host):
    return stage.actor("run", host=Named(host))


def liar(stage):
    return stage.start(
        *(HOSTILE, "--run", "run", "--domain", stage.domain, "--kind", "wrong-reward")
    )


def test_an_audited_run_has_the_same_weights_and_says_what_was_compared(stage, expected):
    learner = stage.learner("run", "--audit", "1")
    team = [actor_on(stage, "one"), actor_on(stage, "two")]
    assert stage.finish("run", learner, team) == expected
    learner.expect_text("in every bit")
    assert "excluded hosts: none" in learner.text


def test_a_host_that_computes_wrongly_is_named_and_excluded(stage, expected):
    learner = stage.learner("run", "--audit", "1")
    false_one = liar(stage)
    learner.expect_text("hostile-wrong-reward")  # it has orders before anybody else is there
    honest = [actor_on(stage, "one"), actor_on(stage, "two")]
    assert false_one.wait() == REFUSED, false_one
    assert "hostile-wrong-reward computes wrongly" in false_one.text
    assert stage.finish("run", learner, honest) == expected
    assert "excluded hosts: hostile-wrong-reward" in learner.text
    assert f"{EPISODES * UPDATES} of {EPISODES * UPDATES}" in learner.text


def test_an_excluded_host_stays_so_when_the_learner_starts_again(stage):
    learner = stage.learner("run", "--audit", "1", small=ENDLESS)
    false_one = liar(stage)
    learner.expect_text("hostile-wrong-reward")
    honest = [actor_on(stage, "one"), actor_on(stage, "two")]
    assert false_one.wait() == REFUSED, false_one
    learner.kill()
    again = stage.learner("run", "--resume", "--audit", "1", small=ENDLESS)
    again.expect_text("it stays excluded")
    returning = liar(stage)
    assert returning.wait() == REFUSED, returning
    assert "hostile-wrong-reward computes wrongly" in returning.text
    for process in (again, *honest):
        process.kill()


def test_without_an_audit_the_same_lie_changes_the_weights(stage, expected):
    learner, false_one = stage.learner("run"), liar(stage)
    assert learner.wait() == 0, learner
    assert stage.inspect(stage.latest("run"))["weights_sha256"] != expected
    false_one.wait()
