"""Output that nobody reads holds up neither learner nor actor, nor Ctrl-C."""

import signal

import pytest

from harness import ACTOR, DEADLINE, ENDLESS, LEARNER, SMALL, UPDATES, parse_json
from unread import start_unread


def start_run(stage, unread, small):
    """@return the learner and its actor. They say much: more than what lies between them and a reader takes."""
    named = ("--run", "run", "--domain", stage.domain)
    learner = (LEARNER, "run", *named, "--runs", stage.runs, "--log-level", "trace", *small)
    actor = (ACTOR, "run", *named, "--log", "trace")
    return [start_unread(stage, unread, command) for command in (learner, actor)]


@pytest.mark.slow
def test_a_run_ends_as_if_somebody_read(stage, unread):
    for child in start_run(stage, unread, SMALL):
        assert child.wait(DEADLINE) == 0
    assert stage.inspect(stage.latest("run"))["version"] == UPDATES


@pytest.mark.slow
def test_ctrl_c_is_served_and_leaves_a_checkpoint(stage, unread):
    running, playing = start_run(stage, unread, ENDLESS)
    watching = stage.status("run", "--follow")
    watching.expect(lambda line: parse_json(line).get("version", 0) > 3, "update 4")
    for child in (playing, running):
        child.send_signal(signal.SIGINT)
        assert child.wait(DEADLINE) == 128 + signal.SIGINT
    assert stage.inspect(stage.latest("run"))["version"] > 3
