#!/usr/bin/env python3
"""Control steps a second of the official Meta-World package under random actions, resets included,
in one process. Prints one JSON object."""

import argparse
import importlib.metadata
import itertools
import json
import time

import numpy as np

import official_tasks


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", required=True)
    parser.add_argument("--seconds", type=float, default=5, help="timed, after a warm-up of a fifth (default 5)")
    return parser.parse_args()


def make_stepper(task):
    """A function that makes one control step, and a reset where the episode is over."""
    environment = official_tasks.makers(task, [1])[0]()
    environment.reset()
    actions = itertools.cycle(np.random.default_rng(1).uniform(-1, 1, (9973, 4)).astype(np.float32))

    def step():
        _, _, terminated, truncated, _ = environment.step(next(actions))
        if terminated or truncated:
            environment.reset()

    return step


def rate_of(step, seconds):
    steps, started = 0, time.perf_counter()
    while True:
        step()
        steps += 1
        elapsed = time.perf_counter() - started
        if elapsed >= seconds:
            return steps / elapsed


def main():
    arguments = parse_arguments()
    step = make_stepper(arguments.task)
    rate_of(step, arguments.seconds / 5)
    print(json.dumps({
        "steps_per_second": rate_of(step, arguments.seconds),
        "metaworld": importlib.metadata.version("metaworld"),
        "mujoco": importlib.metadata.version("mujoco"),
    }))


if __name__ == "__main__":
    main()
