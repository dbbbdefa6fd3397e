"""The gain in time by `collection.overlap: 1` and the wide preset, with actors on cores of their own.

The learner has one core and one thread, the actor another one. On cores that both saturate
together, overlap can win nothing.
"""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile

from suite import _stats, _train

NAME = "overlap"
HELP = "steps a second with and without overlap and with the wide preset; learner and actor on a core each"
EACH_ENGINE = True

WIDE = ["--config", str(pathlib.Path(__file__).resolve().parents[3] / "deploy/wide.textproto")]
SETTINGS = {
    "overlap 0": [],
    "overlap 1": ["--set", "collection.overlap=1"],
    "wide, overlap 0": [*WIDE, "--set", "collection.overlap=0"],
    "wide": WIDE,
}


def pinned(command, core, **streams):
    """A child process with one core to itself, as far as we are concerned."""
    return subprocess.Popen(command, preexec_fn=lambda: os.sched_setaffinity(0, {core}), **streams)


def rate(options, task, steps, arguments):
    """Steps a second of a learner and one actor, each on a core of its own."""
    first, second = sorted(os.sched_getaffinity(0))[:2]
    with tempfile.TemporaryDirectory(prefix="overlap-") as runs:
        name = f"overlap-{os.getpid()}"
        learner = [options.build / "bin/metronome-learner", "run", "--run", name, "--runs", runs, "--task", task]
        learner += ["--steps", str(steps), "--set", "ppo.kl_stop=0", "--set", "runtime.learner_threads=1", *arguments]
        actor = [options.build / "bin/metronome-actor", "run", "--run", name]
        with open(f"{runs}/log", "w+") as log:
            processes = [pinned(learner, first, stdout=log, stderr=log), pinned(actor, second, stdout=log, stderr=log)]
            codes = [process.wait() for process in processes]
            log.seek(0)
            if any(codes):
                sys.exit(f"learner and actor ended with {codes}:\n{log.read()}")
        with open(f"{runs}/{name}/progress.csv", newline="") as file:
            return _train.steady_rate(list(csv.DictReader(file)))


def measure(options, record):
    if len(os.sched_getaffinity(0)) < 2:
        sys.exit("overlap: needs two cores")
    for round_number in range(1, options.rounds + 1):
        for task in options.tasks:
            for setting, arguments in SETTINGS.items():
                wide = setting.startswith("wide")
                updates = 2 if options.quick else 4 if wide else 8
                steps = updates * (50000 if wide else 16000)
                record(case=task, quantity=setting, unit="steps/s", round=round_number,
                       value=rate(options, task, steps, arguments))


def table(rows):
    columns = list(SETTINGS)
    lines = []
    for case, of in _stats.by_case(rows).items():
        gains = [_stats.median_ratio(of["overlap 1"], of["overlap 0"]), _stats.median_ratio(of["wide"], of["wide, overlap 0"])]
        lines.append([case, *(f"{_stats.median(of[name]):.0f}" for name in columns), *(f"{gain:.2f}" for gain in gains)])
    return _stats.markdown(["task", *columns, "gain of overlap", "gain in wide"], lines)
