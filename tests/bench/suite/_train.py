"""Whole trainings by deploy/train, and what their logs say."""

import csv
import os
import re
import shutil
import subprocess
import sys

USES = re.compile(r"([a-z-]+) ([0-9.]+)(?:,|$)")


def run(options, task, *, steps, actors=2, name="", arguments=()):
    """Runs deploy/train with the engine's build; returns (rows of progress.csv, CPU seconds by use).

    CPU seconds are {'physics': ..., 'update': ..., 'wire': ...} over learner and actors, where 'wire' is
    what their processes took beyond the uses that they name: middleware threads and event loops.
    """
    run_name = f"bench-{os.getpid()}-{task}{name}"
    command = [options.root / "deploy/train", task, "--run", run_name, "--build", options.build]
    command += ["--steps", str(steps), "--actors", str(actors), "--mujoco", options.engine, *arguments]
    result = subprocess.run(command, capture_output=True, text=True, cwd=options.root)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{result.stdout}{result.stderr}")
    folder = options.root / "runs" / run_name
    with open(folder / "progress.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    uses = cpu_seconds(folder / "logs")
    shutil.rmtree(folder)
    return rows, uses


def cpu_seconds(logs):
    """Sums what the processes of a run say at their end."""
    uses = {}
    for log in logs.iterdir():
        for line in log.read_text().splitlines():
            if " CPU seconds: " not in line:
                continue
            for use, seconds in USES.findall(line.split(" CPU seconds: ")[1]):
                use = "wire" if use in ("rest", "send") else use
                uses[use] = uses.get(use, 0) + float(seconds)
    return uses


def steady_rate(rows):
    """Environment steps a second from the end of the first update to that of the last."""
    first, last = rows[0], rows[-1]
    steps = int(last["steps"]) - int(first["steps"])
    return steps / (float(last["wall_seconds"]) - float(first["wall_seconds"]))
