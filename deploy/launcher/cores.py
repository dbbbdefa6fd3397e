"""How many cores this process may use: its affinity, and the CPU quotas of its cgroups."""

import math
import os
import re
from pathlib import Path


def usable(root="/"):
    """@param root  where /proc and the cgroups' file systems are found."""
    mine, limit = len(os.sched_getaffinity(0)), quota(root)
    return mine if limit is None else max(1, min(mine, math.ceil(limit)))


def quota(root="/"):
    """@return how many cores the narrowest of our cgroups, and of those around them, may keep busy;
    None: any."""
    limits = [limit for folder, top in _cgroups(Path(root)) for limit in _limits(folder, top)]
    return min(limits, default=None)


def _cgroups(root):
    """Folder of each of our cgroups that may limit processors, and of the outermost one seen."""
    try:
        ours = [line.split(":", 2) for line in _lines(root / "proc/self/cgroup")]
        mounts = [line.split(" ") for line in _lines(root / "proc/self/mountinfo")]
    except OSError:
        return
    for mount in mounts:
        kind, options = mount[mount.index("-") + 1], mount[-1].split(",")
        if kind != "cgroup2" and (kind != "cgroup" or "cpu" not in options):
            continue
        inside, top = _unescaped(mount[3]), root / _unescaped(mount[4]).lstrip("/")
        for number, controllers, path in ours:
            if (number == "0") if kind == "cgroup2" else ("cpu" in controllers.split(",")):
                # A container may see its own cgroup as the outermost one, by its path outside.
                below = os.path.relpath(path, inside)
                yield (top if below.startswith("..") else top / below), top


def _lines(path):
    return path.read_text(errors="surrogateescape").splitlines()


def _unescaped(word):
    return re.sub(r"\\([0-7]{3})", lambda match: chr(int(match[1], 8)), word)


def _limits(folder, top):
    while True:
        limit = _limit(folder)
        if limit is not None:
            yield limit
        if folder == top or top not in folder.parents:
            return
        folder = folder.parent


def _limit(folder):
    """Of one cgroup, by either version's files."""
    try:
        if (folder / "cpu.max").exists():
            budget, period = (folder / "cpu.max").read_text().split()
        else:
            budget = (folder / "cpu.cfs_quota_us").read_text()
            period = (folder / "cpu.cfs_period_us").read_text()
        limit = int(budget) / int(period)
    except (OSError, ValueError, ZeroDivisionError):  # "max", or nothing to be read
        return None
    return limit if limit > 0 else None
