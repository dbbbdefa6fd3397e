"""Signals that stop learner and actor, and those that whoever started them asked to be ignored."""

import signal

import pytest

from harness import ACTOR, ENDLESS, LEARNER


def learner(stage, run, *before):
    return stage.start(
        *before, LEARNER, "run", "--run", run, "--runs", stage.runs, "--domain", stage.domain,
        "--progress", "json", *ENDLESS,
    )


def actor(stage, run, *before):
    return stage.start(*before, ACTOR, "run", "--run", run, "--domain", stage.domain)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.slow
def test_each_stop_signal_ends_learner_and_actor_and_leaves_a_checkpoint(stage, number):
    running, playing = learner(stage, "run"), actor(stage, "run")
    running.expect_update(2)
    playing.signal(number)
    assert playing.wait() == 128 + number, playing
    running.signal(number)
    assert running.wait() == 128 + number, running
    assert stage.inspect(stage.latest("run"))["version"] >= 2


@pytest.mark.parametrize("ignored, other", [("HUP", "TERM"), ("INT", "TERM"), ("TERM", "INT")])
@pytest.mark.slow
def test_a_signal_that_is_ignored_at_the_start_stays_ignored(stage, ignored, other):
    ignoring = ("env", f"--ignore-signal={ignored}")  # as nohup does, and a script of its background jobs
    running, playing = learner(stage, "run", *ignoring), actor(stage, "run", *ignoring)
    running.expect_update(1)
    for process in (running, playing):
        process.signal(signal.Signals[f"SIG{ignored}"])
    running.expect_update(running.updates() + 5)  # with the only actor
    for process in (playing, running):
        number = signal.Signals[f"SIG{other}"]
        process.signal(number)
        assert process.wait() == 128 + number, process
