"""Standard output and standard error of programs whose work matters more than being read.

A terminal may be paused, a pipe or a disk full, a reader gone, a stream closed. None of that may
hold up or end the work that is told of."""

import atexit
import codecs
import collections
import io
import os
import select
import signal
import socket
import stat
import sys
import time

MOST_WAITING = 1 << 16  # bytes that wait for a slow reader; beyond it the oldest are given up
LAST_WORDS = 3.0  # seconds that they are given at the end


def _as_it_is(error):
    """For what the encoding lacks: names that are not UTF-8 as they are on disk, else escapes."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return (
        b"".join(
            bytes([ord(letter) - 0xDC00])
            if 0xDC80 <= ord(letter) <= 0xDCFF
            else letter.encode("ascii", "backslashreplace")
            for letter in text
        ),
        error.end,
    )


codecs.register_error("as-it-is", _as_it_is)


def prepare():
    """To be called first in a program. Streams that are closed lead nowhere from now on, so that no
    file that is opened later takes their place; any text can be written to the others. How children
    end can be seen, which is not so where our parent ignores that (SIGCHLD)."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for fd in range(3):
        try:
            os.fstat(fd)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest free number
    for name, fd in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, open(fd, "w", closefd=False))
        getattr(sys, name).reconfigure(errors="as-it-is")


def never_block():
    """From now on what is written to sys.stdout and sys.stderr is shown as far as that is possible
    at once; the rest waits, at the end of the program LAST_WORDS seconds more. Writing never fails.
    @return the Outlets, for children.Events.relieve."""
    outlets = []
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        stream.flush()
        outlets.append(Outlet(stream.fileno(), stream.encoding))
        setattr(sys, name, outlets[-1])
    atexit.register(_say_last_words, outlets)
    return outlets


def _say_last_words(outlets):
    deadline = time.monotonic() + LAST_WORDS
    for outlet in outlets:
        outlet.drain(deadline - time.monotonic())


class Outlet(io.TextIOBase):
    """Text for an open file; see never_block()."""

    def __init__(self, fd, encoding):
        self._tty, self._encoding = os.isatty(fd), encoding
        self._fd, self._send = _opened(fd)
        self._text = ""
        self._waiting, self._size = collections.deque(), 0
        self._begun = False  # whether a part of the oldest is written

    @property
    def encoding(self):
        return self._encoding

    @property
    def waiting(self):
        """True while there is something to write once the file takes it."""
        return bool(self._waiting)

    def fileno(self):
        return self._fd

    def isatty(self):
        return self._tty

    def writable(self):
        return True

    def write(self, text):
        self._text += text
        if "\n" in text:
            self.flush()
        return len(text)

    def flush(self):
        if self._text:
            data, self._text = self._text.encode(self._encoding, "as-it-is"), ""
            self._waiting.append(data)
            self._size += len(data)
        self._push()
        while self._size > MOST_WAITING and len(self._waiting) > 1 + self._begun:
            self._size -= len(self._waiting[self._begun])
            del self._waiting[self._begun]

    def drain(self, seconds):
        """Blocks until nothing waits, for `seconds` at most."""
        deadline = time.monotonic() + seconds
        self.flush()
        poll = select.poll()
        poll.register(self._fd, select.POLLOUT)
        while self._waiting and (left := deadline - time.monotonic()) > 0:
            poll.poll(1000 * left)
            self._push()

    def _push(self):
        while self._waiting:
            oldest = self._waiting[0]
            try:
                count = self._send(oldest)
            except BlockingIOError:
                return
            except OSError:  # a full disk, a reader that left: what waits is given up
                self._waiting.clear()
                self._size, self._begun = 0, False
                return
            self._size -= count
            self._begun = count < len(oldest)
            if self._begun:
                self._waiting[0] = oldest[count:]
            else:
                self._waiting.popleft()


def _opened(fd):
    """@return a descriptor for what `fd` leads to, and a function that writes to it without blocking."""
    kind = os.fstat(fd).st_mode
    if stat.S_ISSOCK(kind):
        peer = socket.socket(fileno=os.dup(fd))
        return peer.fileno(), lambda data: peer.send(data, socket.MSG_DONTWAIT)
    if stat.S_ISFIFO(kind) or os.isatty(fd):
        # O_NONBLOCK belongs to one opening of a file; that of `fd` is shared, with the shell say.
        try:
            own = os.open(f"/proc/self/fd/{fd}", os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
            return own, lambda data: os.write(own, data)
        except OSError:  # a terminal of another user, say
            return _asked_first(fd, select.PIPE_BUF if stat.S_ISFIFO(kind) else 1)
    own = os.dup(fd)
    return own, lambda data: os.write(own, data)


def _asked_first(fd, most):
    """@param most  bytes for which there is room when the kernel says that there is any."""
    own, poll = os.dup(fd), select.poll()
    poll.register(own, select.POLLOUT)

    def send(data):
        if not poll.poll(0):
            raise BlockingIOError
        return os.write(own, data[:most])

    return own, send
