"""Invented results, written as deploy/experiment does, for tests alone; never below results/."""

import csv
import math
import random

from result_files import ResultFiles

TASKS = ("assembly", "bin-picking", "box-close", "push")


def _write(path, columns, rows):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def cell(results, experiment, task, arm, seed, *, method="multihead", heads=10, updates=50,
         steps_per_update=40000, horizon=500, level=0.6, evaluations=4):
    """One finished cell: a curve that rises towards `level`.  @return its experiment's ResultFiles."""
    rng = random.Random(f"{experiment} {task} {arm} {seed}")
    reach, pace = min(0.98, max(0.02, rng.gauss(level, 0.12))), rng.uniform(5, 9)

    def share(i):
        return reach / (1 + math.exp(4 - pace * i / updates * 1.4))

    progress, evaluated = [], []
    for i in range(1, updates + 1):
        success = min(1.0, max(0.0, round((share(i) + rng.gauss(0, 0.05)) * 16) / 16))
        progress.append({
            "steps": i * steps_per_update, "update": i,
            "return": horizon * 10 * (0.04 + 0.8 * share(i)) * rng.uniform(0.93, 1.07),
            "success": success, "success_end": success * 0.875,
            "wall_seconds": i * rng.uniform(0.98, 1.02) * steps_per_update / 9000})
        if evaluations and i % (updates // evaluations) == 0:
            good = round(50 * min(1.0, 1.1 * share(i))) / 50
            evaluated.append({
                "steps": i * steps_per_update, "update": i, "placements": "random", "episodes": 50,
                "success": good, "success_end": good * 0.9, "return": horizon * 9 * share(i),
                "time_to_success": f"{rng.uniform(90, 160):.1f}" if good else "", "success_200": good * 0.8})
    for before, after in zip(progress, progress[1:]):
        after["wall_seconds"] = max(after["wall_seconds"], before["wall_seconds"] + 0.1)
    files = ResultFiles(results / experiment)
    files.publish({
        "run": f"{task}-{arm}-s{seed}", "experiment": experiment, "task": task, "arm": arm, "seed": seed,
        "method": method, "heads": heads, "steps": updates * steps_per_update,
        "config": f"collection {{\n  horizon: {horizon}\n}}\n"}, progress, evaluated)
    return files


ARMS = {"multihead": ("multihead", 10, 0.7), "ppo": ("ppo", 1, 0.45), "ppo-time": ("ppo-time", 1, 0.5)}


def main_experiment(results, seeds=5, tasks=TASKS, **options):
    for task in tasks:
        for arm, (method, heads, level) in ARMS.items():
            for seed in range(1, seeds + 1):
                cell(results, "main", task, arm, seed, method=method, heads=heads, level=level, **options)


def exchange(results, task, returns):
    """@param returns  order of heads to mean return."""
    (results / "exchange").mkdir(parents=True, exist_ok=True)
    columns = ("order", "success", "success_end", "return", "time_to_success", "episodes", "seed")
    _write(results / "exchange" / f"{task}.csv", columns, [
        {"order": order, "success": value / 5000, "success_end": value / 10000, "return": value, "time_to_success": "",
         "episodes": 50, "seed": 4242} for order, value in returns.items()])
