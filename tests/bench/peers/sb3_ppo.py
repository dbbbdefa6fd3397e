#!/usr/bin/env python3
"""PPO of Stable-Baselines3 on the official Meta-World package, with the benchmark's batch and network
size (one head): training steps a second end to end, after a first update of warm-up. Prints one JSON
object.

Neither Monitor nor VecNormalize is in the way: without them it is at its fastest.
"""

import argparse
import importlib.metadata
import json
import time

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

import sb3_environments

BATCH = 8000  # steps an update


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True)
    parser.add_argument("--steps", type=int, default=24000, help="in all, the first 8000 untimed (default 24000)")
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--vectorisation", choices=["dummy", "subproc"], default="subproc")
    parser.add_argument("--threads", type=int, default=2, help="of PyTorch (default 2)")
    arguments = parser.parse_args()
    if BATCH % arguments.envs or arguments.steps < 2 * BATCH:
        parser.error(f"--envs must divide {BATCH}, and --steps be at least {2 * BATCH}")
    return arguments


class RolloutStarts(BaseCallback):
    """When each rollout started, and that of a rollout never made: the end of the last update."""

    def __init__(self):
        super().__init__()
        self.times, self.steps = [], []

    def note(self):
        self.times.append(time.perf_counter())
        self.steps.append(self.num_timesteps)

    def _on_rollout_start(self):
        self.note()

    def _on_training_end(self):
        self.note()

    def _on_step(self):
        return True


def make_model(arguments):
    environments = sb3_environments.make(arguments.task, arguments.envs, arguments.vectorisation)
    return PPO(
        "MlpPolicy", environments, device="cpu", seed=1,
        policy_kwargs={"net_arch": {"pi": [128, 128], "vf": [128, 128]}, "activation_fn": torch.nn.Tanh},
        n_steps=BATCH // arguments.envs, batch_size=1000, n_epochs=10, learning_rate=5e-4, gamma=0.99,
        gae_lambda=0.95, clip_range=0.2, ent_coef=0.005, vf_coef=0.5, max_grad_norm=0.5)


def main():
    arguments = parse_arguments()
    torch.set_num_threads(arguments.threads)
    model, starts = make_model(arguments), RolloutStarts()
    model.learn(arguments.steps, callback=starts)
    model.get_env().close()
    print(json.dumps({
        "steps_per_second": (model.num_timesteps - starts.steps[1]) / (starts.times[-1] - starts.times[1]),
        "stable_baselines3": importlib.metadata.version("stable_baselines3"),
        "metaworld": importlib.metadata.version("metaworld"),
        "mujoco": importlib.metadata.version("mujoco"),
    }))


if __name__ == "__main__":
    main()
