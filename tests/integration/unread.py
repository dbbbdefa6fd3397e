"""Outputs of a process that nobody reads."""

import contextlib
import os
import pty
import termios

import pytest

import children


@contextlib.contextmanager
def full_pipe():
    """A pipe that takes nothing more."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(write, b"x" * 4096)
    os.set_blocking(write, True)
    yield write
    os.close(read)
    os.close(write)


@contextlib.contextmanager
def paused_terminal():
    """As after Ctrl-S."""
    master, slave = pty.openpty()
    termios.tcflow(slave, termios.TCOOFF)
    yield slave
    os.close(master)
    os.close(slave)


@pytest.fixture(params=[full_pipe, paused_terminal], ids=["full pipe", "paused terminal"])
def unread(request):
    with request.param() as fd:
        yield fd


def start_unread(stage, fd, command):
    """The test's end kills it, as it does stage's processes."""
    child = children.start([str(word) for word in command], obeys=children.STOP_SIGNALS, stdout=fd, stderr=fd)
    stage.callbacks.append(child.kill)
    return child
