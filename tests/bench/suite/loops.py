"""The actor's loop against the bare engine: control steps a second, one and two threads."""

import json
import statistics
import subprocess

from suite import _stats

NAME = "loops"
HELP = "the actor's loop against the bare engine, replaying the same actions"
EACH_ENGINE = True


def rates(build, task, quick=False, pattern="bare|actor"):
    """{'bare x1': control steps a second, ...} of one interleaved run of the C++ benchmark."""
    command = [
        build / "bin/physics_bench",
        f"--benchmark_filter=^({pattern})/{task}/",
        f"--benchmark_min_time={0.05 if quick else 1.5}",
        "--benchmark_enable_random_interleaving=true",
        "--benchmark_format=json",
    ]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    found = {}
    for row in report["benchmarks"]:
        parts = row["name"].split("/")
        found[f"{parts[0]} x{parts[-1].split(':')[1]}"] = row["items_per_second"]
    return found


def measure(options, record):
    for round_number in range(1, options.rounds + 1):
        for task in options.tasks:
            for quantity, value in rates(options.build, task, options.quick).items():
                record(case=task, quantity=quantity, unit="steps/s", round=round_number, value=value)


def table(rows):
    columns = ["bare x1", "actor x1", "bare x2", "actor x2"]
    lines, ratios = [], []
    for case, of in _stats.by_case(rows).items():
        ratio = [_stats.median_ratio(of[f"actor x{n}"], of[f"bare x{n}"]) for n in (1, 2)]
        ratios.append(ratio)
        lines.append([case, *(f"{_stats.median(of[name]):.0f}" for name in columns), *(f"{r:.2f}" for r in ratio)])
    means = [f"{statistics.mean(column):.2f}" for column in zip(*ratios)]
    lines.append(["mean", *[""] * len(columns), *means])
    return _stats.markdown(["task", *columns, "actor/bare x1", "actor/bare x2"], lines)
