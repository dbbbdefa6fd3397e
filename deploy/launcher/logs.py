"""Logs: their loss, of a full disk say, never costs more than the lines."""

import os

LINES = 20  # of a log, that are shown when its process failed


class Log:
    """A file that lines are added to. Its folder is made; each line tries anew."""

    def __init__(self, path):
        self._path, self._file = path, None

    def append(self, line):
        """@param line  bytes without the end of the line."""
        try:
            if self._file is None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = open(self._path, "ab", buffering=0)
            self._file.write(line + b"\n")
        except OSError:
            pass

    def close(self):
        if self._file is not None:
            self._file.close()


def open_for_child(path):
    """@return a file for a child's output; where none can be made, what leads nowhere."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return open(path, "ab")
    except OSError:
        return open(os.devnull, "wb")


def tail(path, lines=LINES):
    """@return the last lines, indented."""
    try:
        with open(path, "rb") as log:
            log.seek(max(0, os.path.getsize(path) - 65536))
            found = log.read().decode(errors="surrogateescape").splitlines()
    except OSError as error:
        found = [f"({error})"]
    return "\n".join("  " + line for line in found[-lines:])
