"""Files that are whole or not there: a program that is stopped leaves no half of one."""

import contextlib
import os


@contextlib.contextmanager
def replacing(path):
    """A path to write to, of the same suffix; at the end of the block it takes the place of `path`, or, if the
    block failed, is removed."""
    partial = path.with_name(f".{path.name}.new{path.suffix}")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def write(path, text):
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")
