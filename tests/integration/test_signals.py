"""Signals that stop learner and actor, and those that whoever started them asked to be ignored."""

import signal

import pytest

from harness import ACTOR, ENDLESS, LEARNER

IGNORING = ("bash", "-c", 'trap "" {}; exec "$@"', "bash")


def ignoring(*names):
    """The beginning of a command line that ignores these signals, as nohup and background jobs of a script do."""
    return [word.format(" ".join(names)) for word in IGNORING]


def learner(stage, run, *before):
    return stage.start(
        *before, LEARNER, "run", "--run", run, "--runs", stage.runs, "--domain", stage.domain,
        "--progress", "json", *ENDLESS,
    )


def actor(stage, run, *before):
    return stage.start(*before, ACTOR, "run", "--run", run, "--domain", stage.domain)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_each_stop_signal_ends_learner_and_actor_and_leaves_a_checkpoint(stage, number):
    running, playing = learner(stage, "run"), actor(stage, "run")
    running.expect_update(2)
    playing.signal(number)
    assert playing.wait() == 128 + number, playing
    running.signal(number)
    assert running.wait() == 128 + number, running
    assert stage.inspect(stage.latest("run"))["version"] >= 2


@pytest.mark.parametrize("ignored, other", [("HUP", "TERM"), ("INT", "TERM"), ("TERM", "INT")])
def test_a_signal_that_is_ignored_at_the_start_stays_ignored(stage, ignored, other):
    running = learner(stage, "run", *ignoring(ignored))
    playing = actor(stage, "run", *ignoring(ignored))
    running.expect_update(1)
    for process in (running, playing):
        process.signal(signal.Signals[f"SIG{ignored}"])
    running.expect_update(running.updates() + 5)  # with the only actor
    for process in (playing, running):
        number = signal.Signals[f"SIG{other}"]
        process.signal(number)
        assert process.wait() == 128 + number, process
