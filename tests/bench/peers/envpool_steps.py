#!/usr/bin/env python3
"""Control steps a second of EnvPool's Meta-World under random actions, resets included.

Sync: every call steps all environments. Async: a call hands back the half (--batch) that is done
first, EnvPool's usual way. A call that resets an environment does not count as a step of it. Prints
one JSON object.
"""

import argparse
import importlib.metadata
import itertools
import json
import time

import numpy as np

import envpool_tasks


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True)
    parser.add_argument("--mode", choices=["sync", "async"], default="sync")
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--batch", type=int, help="of a call, async only (default: half of --envs)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=5, help="timed, after a warm-up of a fifth (default 5)")
    return parser.parse_args()


def make_stepper(arguments):
    """A function that makes one call and returns how many control steps came of it."""
    batch = arguments.envs if arguments.mode == "sync" else arguments.batch or max(1, arguments.envs // 2)
    environment = envpool_tasks.make(
        arguments.task, num_envs=arguments.envs, batch_size=batch, num_threads=arguments.threads, seed=1)
    # Drawn beforehand: the draw is not what is measured.
    actions = itertools.cycle(np.random.default_rng(1).uniform(-1, 1, (997, batch, 4)).astype(np.float32))

    def step_sync():
        return environment.step(next(actions))[4]

    def step_async():
        info = environment.recv()[4]
        environment.send(next(actions), info["env_id"])
        return info

    step = {"sync": step_sync, "async": step_async}[arguments.mode]
    environment.reset() if arguments.mode == "sync" else environment.async_reset()
    return lambda: int(np.count_nonzero(step()["elapsed_step"]))  # 0 right after a reset


def rate_of(step, seconds):
    steps, started = 0, time.perf_counter()
    while True:
        steps += step()
        elapsed = time.perf_counter() - started
        if elapsed >= seconds:
            return steps / elapsed


def main():
    arguments = parse_arguments()
    step = make_stepper(arguments)
    rate_of(step, arguments.seconds / 5)
    print(json.dumps({
        "steps_per_second": rate_of(step, arguments.seconds),
        "envpool": importlib.metadata.version("envpool"),
    }))


if __name__ == "__main__":
    main()
