"""Child processes that never outlive this one, and the events to wait for."""

import ctypes
import os
import selectors
import signal
import subprocess
import sys
import time

_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG = 1
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def _sent_when_we_die(number):
    """For preexec_fn: the kernel sends the child `number` when this process ends, however it does.
    It watches the thread that forked: start children from the main thread only."""
    parent = os.getpid()

    def before_exec():
        _LIBC.prctl(_PR_SET_PDEATHSIG, number)
        if os.getppid() != parent:
            os._exit(1)

    return before_exec


def start(command, **streams):
    """Starts `command` in a session of its own, so that a terminal's Ctrl-C reaches only us and we
    decide the order of stopping."""
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=_sent_when_we_die(signal.SIGKILL),
        **streams
    )


def run_in_foreground(command):
    """Runs `command` with our terminal (it may ask for a password) to its end.
    @return its exit code. SIGTERM ends it, and us with 143."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    child = subprocess.Popen(command, preexec_fn=_sent_when_we_die(signal.SIGTERM))
    try:
        return child.wait()
    except BaseException:
        child.terminate()
        child.wait()
        raise


def stop(children, steps):
    """Sends each signal of `steps`, (signal, seconds to wait after it), to those of `children` that
    still run, until none does. Blocks at most the sum of the seconds."""
    for number, seconds in steps:
        deadline = time.monotonic() + seconds
        for child in children:
            if child.poll() is None:
                child.send_signal(number)
        for child in children:
            try:
                child.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                pass


class Events:
    """Waits for signals, ends of children and output in one place, in one thread."""

    def __init__(self):
        self._selector = selectors.DefaultSelector()
        self._stops = []  # stop signals that wait() has not told of yet
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)
        signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        for number in (*STOP_SIGNALS, signal.SIGCHLD):
            signal.signal(number, lambda *_: None)
        self._selector.register(self._read, selectors.EVENT_READ, None)

    def watch(self, stream, on_line):
        """Calls `on_line(bytes)` for each line that `stream` brings, inside wait()."""
        os.set_blocking(stream.fileno(), False)
        self._selector.register(stream, selectors.EVENT_READ, (on_line, bytearray()))

    def wait(self, timeout):
        """Blocks until something happens or `timeout` seconds (None: forever) have passed.
        @return the stop signals that arrived."""
        self._take(0 if self._stops else timeout)
        stops, self._stops = self._stops, []
        return stops

    def drain(self):
        """Reads what ended children left in their pipes; wait() tells of stop signals that come meanwhile."""
        while any(key.data for key, _ in self._selector.select(0)):
            self._take(0)

    def _take(self, timeout):
        for key, _ in self._selector.select(timeout):
            if key.data is None:
                self._stops += [n for n in os.read(self._read, 4096) if n in STOP_SIGNALS]
            else:
                self._read_lines(key)

    def _read_lines(self, key):
        on_line, rest = key.data
        data = os.read(key.fd, 65536)
        rest += data
        if not data:
            self._selector.unregister(key.fileobj)
            rest += b"\n" if rest else b""
        *lines, tail = bytes(rest).split(b"\n")
        rest[:] = tail
        for line in lines:
            on_line(line)
