"""Child processes that never outlive this one, and the events to wait for."""

import ctypes
import functools
import os
import selectors
import signal
import subprocess
import sys
import time

import stops

_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG = 1
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WE_STOP_BY = (signal.SIGINT, signal.SIGTERM)  # SIGHUP stays ignored in a child if it is here (nohup)


def _sent_when_we_die(number, obeys=()):
    """For preexec_fn: the kernel sends the child `number` when this process ends, however it does.
    It watches the thread that forked: start children from the main thread only."""
    parent = os.getpid()

    def before_exec():
        for each in obeys:
            signal.signal(each, signal.SIG_DFL)
        _LIBC.prctl(_PR_SET_PDEATHSIG, number)
        if os.getppid() != parent:
            os._exit(1)

    return before_exec


def start(command, at_our_death=signal.SIGKILL, obeys=WE_STOP_BY, **streams):
    """Starts `command` in a session of its own, so that a terminal's Ctrl-C reaches only us and we
    decide the order of stopping.
    @param at_our_death  the signal that it gets when we are killed.
    @param obeys  signals that act on it even where they are ignored by us."""
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=_sent_when_we_die(at_our_death, obeys),
        **streams
    )


def said_by(command):
    """Runs `command` to its end. @return subprocess.CompletedProcess with all that it said, as text. It ends when we do:
    an exception that comes before subprocess.run knows its child (a stop, stops.exit_on_stop) leaves it running."""
    return subprocess.run(command, capture_output=True, text=True, errors="surrogateescape",
                          preexec_fn=_sent_when_we_die(signal.SIGKILL))


def run_in_foreground(command):
    """Runs `command` with our terminal (it may ask for a password) to its end.
    @return its exit code. SIGTERM ends it, and us with 143."""
    stops.handle(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    child = subprocess.Popen(command, preexec_fn=_sent_when_we_die(signal.SIGTERM))
    try:
        return child.wait()
    except BaseException:
        child.terminate()
        child.wait()
        raise


class Events:
    """Waits for signals, ends of children and output in one place, in one thread."""

    def __init__(self):
        self._selector = selectors.DefaultSelector()
        self._stops = []  # stop signals that wait() has not told of yet
        self._outlets = []
        self._muted = False
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)
        signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        for number in STOP_SIGNALS:
            stops.handle(number, lambda *_: None)
        signal.signal(signal.SIGCHLD, lambda *_: None)  # ignored, it would hide how children ended
        signal.signal(signal.SIGTTOU, signal.SIG_IGN)  # what a terminal stops its writers by (tostop)
        self._selector.register(self._read, selectors.EVENT_READ, self._take_signals)

    def watch(self, stream, on_line):
        """Calls `on_line(bytes)` for each line that `stream` brings, inside wait()."""
        os.set_blocking(stream.fileno(), False)
        self._selector.register(
            stream,
            selectors.EVENT_READ,
            functools.partial(self._take_lines, stream, on_line, bytearray()),
        )

    def relieve(self, outlets):
        """Lets terminal.Outlets write what waits in them, inside wait()."""
        self._outlets += outlets

    def mute(self):
        """Reads the watched streams from now on and throws away what they bring."""
        self._muted = True

    def wait(self, timeout):
        """Blocks until something happens or `timeout` seconds (None: forever) have passed.
        @return the stop signals that arrived."""
        self._take(0 if self._stops else timeout)
        stops, self._stops = self._stops, []
        return stops

    def drain(self):
        """Reads what ended children left in their pipes; wait() tells of stop signals that come
        meanwhile."""
        while any(isinstance(key.data, functools.partial) for key, _ in self._selector.select(0)):
            self._take(0)

    def stop(self, children, steps):
        """Sends each signal of `steps`, (signal, seconds to wait after it), to those of `children`
        that still run, until none does; reads what they say meanwhile. Blocks at most the sum of
        the seconds."""
        for number, seconds in steps:
            running = [child for child in children if child.poll() is None]
            for child in running:
                child.send_signal(number)
            deadline = time.monotonic() + seconds
            while any(child.poll() is None for child in running):
                left = deadline - time.monotonic()
                if left <= 0:
                    break
                self._take(left)

    def _take(self, timeout):
        for outlet in self._outlets:
            registered = outlet.fileno() in self._selector.get_map()
            if outlet.waiting and not registered:
                self._selector.register(outlet, selectors.EVENT_WRITE, outlet.flush)
            elif registered and not outlet.waiting:
                self._selector.unregister(outlet)
        for key, _ in self._selector.select(timeout):
            key.data()

    def _take_signals(self):
        self._stops += [n for n in os.read(self._read, 4096) if n in STOP_SIGNALS]

    def _take_lines(self, stream, on_line, rest):
        data = os.read(stream.fileno(), 65536)
        rest += data
        if not data:
            self._selector.unregister(stream)
            rest += b"\n" if rest else b""
        *lines, tail = bytes(rest).split(b"\n")
        rest[:] = tail
        for line in lines:
            if not self._muted:
                on_line(line)
