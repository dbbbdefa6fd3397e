"""The official scripted policies' episodes of all tasks, as `metronome-actor tasks` tells them."""

import re
from dataclasses import dataclass

import children
from cells import ResultsError


@dataclass(frozen=True)
class Expert:
    """Means over its episodes of 500 steps."""

    success: float  # share of episodes, at any step
    success_end: float  # at the last step
    mean_return: float


def found(program):
    """Task to Expert, empty where there is no program. @throws ResultsError."""
    if program is None:
        return {}
    done = children.said_by([str(program), "tasks"])
    if done.returncode != 0:
        raise ResultsError(f"{program} tasks: {done.stderr.strip()}")
    return read(done.stdout)


def read(table):
    """@param table  columns with two spaces or more between them, named in the first line."""
    header, *rows = (re.split(r"\s{2,}", line.strip()) for line in table.splitlines())
    try:
        records = [dict(zip(header, row)) for row in rows]
        return {row["task"]: Expert(_share(row["any"]), _share(row["last"]), float(row["return"])) for row in records}
    except (KeyError, ValueError) as error:
        raise ResultsError(f"metronome-actor tasks prints another table than is known here ({error}): build it anew, "
                           "by deploy/setup") from error


def _share(percent):
    return float(percent.removesuffix("%")) / 100
