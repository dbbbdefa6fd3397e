"""Output that nobody reads - a full pipe, a paused terminal - holds up neither training nor Ctrl-C."""

import os
import pty
import signal
import termios

import pytest

import children
from harness import ACTOR, DEADLINE, ENDLESS, LEARNER, SMALL, UPDATES, parse_json


def full_pipe():
    """@return the two ends of a pipe with no room."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    try:
        while True:
            os.write(write, b"x" * 65536)
    except BlockingIOError:
        pass
    os.set_blocking(write, True)
    return read, write


def paused_terminal():
    """@return the two ends of a terminal on which somebody pressed Ctrl-S."""
    outer, inner = pty.openpty()
    termios.tcflow(inner, termios.TCOOFF)
    return outer, inner


@pytest.fixture(params=[full_pipe, paused_terminal])
def unread(request):
    """What a process may write to, and nobody reads."""
    reader, writer = request.param()
    yield writer
    os.close(reader)
    os.close(writer)


@pytest.fixture
def start():
    """Starts a process of which both streams go to a descriptor."""
    started = []

    def start_it(output, *command):
        child = children.start([str(word) for word in command], stdout=output, stderr=output)
        started.append(child)
        return child

    yield start_it
    for child in started:
        child.kill()
        child.wait()


def learner(stage, small):
    # Short lines and a trace of them: more than any buffer between us takes.
    return (LEARNER, "run", "--run", "run", "--runs", stage.runs, "--domain", stage.domain,
            "--log-level", "trace", *small)


def test_a_run_ends_as_if_somebody_read(stage, unread, start):
    running = start(unread, *learner(stage, SMALL))
    playing = start(unread, ACTOR, "run", "--run", "run", "--domain", stage.domain, "--log", "trace")
    assert running.wait(DEADLINE) == 0
    assert playing.wait(DEADLINE) == 0
    assert stage.inspect(stage.latest("run"))["version"] == UPDATES


def test_ctrl_c_is_served_and_leaves_a_checkpoint(stage, unread, start):
    running = start(unread, *learner(stage, ENDLESS))
    playing = start(unread, ACTOR, "run", "--run", "run", "--domain", stage.domain)
    watching = stage.status("run", "--follow")
    watching.expect(lambda line: parse_json(line).get("version", 0) > 3, "update 4")
    for child in (playing, running):
        child.send_signal(signal.SIGINT)
        assert child.wait(DEADLINE) == 128 + signal.SIGINT
    assert stage.inspect(stage.latest("run"))["version"] > 3
