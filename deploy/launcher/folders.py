"""Folders that a person names: what can be said of them before anything is written."""

import os
import shutil
import stat
from pathlib import Path


def shown(path):
    """A path as a person would type it: relative, where it lies below."""
    try:
        relative = os.path.relpath(path)
    except OSError:  # the current folder was removed
        return str(path)
    return str(path) if relative.startswith("..") else relative


def typed(program):
    """shown(program), or its name alone where that is enough for a shell."""
    found = shutil.which(program.name)
    return program.name if found and os.path.exists(program) and os.path.samefile(found, program) else shown(program)


def absolute(path):
    """@throws OSError, whose message is for people."""
    try:
        return Path(path).absolute()
    except FileNotFoundError:
        raise OSError(f"{path} begins at the current folder, which was removed: "
                      "change to another one, or name the whole path") from None


def require_file(path):
    """@throws OSError, whose message is for people, unless `path` is a file."""
    try:
        is_file = stat.S_ISREG(os.stat(path).st_mode)
    except OSError as error:
        raise OSError(f"{path}: {error.strerror}") from None
    if not is_file:
        raise OSError(f"{path} is not a file")


def usable(path):
    """@return the absolute path of a folder that is there or could be made by that name.
    @throws OSError, whose message is for people."""
    path = absolute(path)
    for place in (*reversed(path.parents), path):
        if os.path.islink(place) and not os.path.exists(place):
            raise OSError(f"{place} is a link to {os.readlink(place)}, which is not there: "
                          "make that folder, or remove the link")
        if os.path.lexists(place) and not os.path.isdir(place):
            raise OSError(f"{place} is not a folder: move it away, or name another")
    return path


def writable(path, option):
    """@return usable(path), in which files can be made once it is there.
    @throws OSError, whose message is for people and names `option` as the way out."""
    path = usable(path)
    there = next(place for place in (path, *path.parents) if os.path.exists(place))
    if not os.access(there, os.W_OK | os.X_OK):
        raise OSError(f"cannot write to {path} (it is another user's, or read-only): "
                      f"name a folder of your own by {option} DIR")
    return path
