#!/usr/bin/env python3
"""SAC of Stable-Baselines3 on the official Meta-World package, with Metronome's ratio of gradient samples to steps
and its widths (one head, values by regression): training steps a second end to end, after first steps
at random, which are untimed. Prints one JSON object.
"""

import argparse
import importlib.metadata
import json
import time

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.callbacks import BaseCallback

import sb3_environments


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True)
    parser.add_argument("--steps", type=int, default=8000, help="timed, after 2048 of warm-up (default 8000)")
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--vectorisation", choices=["dummy", "subproc"], default="subproc")
    parser.add_argument("--threads", type=int, default=2, help="of PyTorch (default 2)")
    parser.add_argument("--batch", type=int, default=256)
    parser.add_argument("--replay-ratio", type=int, default=8, help="samples of gradient steps for each step (default 8)")
    parser.add_argument("--hidden", type=int, nargs="+", default=[128, 128], help="widths of the policy (default 128 128)")
    parser.add_argument("--critic-hidden", type=int, nargs="+", default=[128, 128], help="of each critic (default 128 128)")
    arguments = parser.parse_args()
    arguments.steps_between = arguments.batch // arguments.replay_ratio  # of one gradient step and the next
    if arguments.batch % arguments.replay_ratio or arguments.steps_between % arguments.envs:
        parser.error("--envs must divide the steps between gradient steps, --batch / --replay-ratio")
    return arguments


class Timer(BaseCallback):
    """Seconds and steps from the end of the warm-up to that of the training."""

    def __init__(self, warm_up):
        super().__init__()
        self.warm_up, self.started, self.first = warm_up, None, 0

    def _on_rollout_start(self):
        if self.started is None and self.num_timesteps >= self.warm_up:
            self.started, self.first = time.perf_counter(), self.num_timesteps

    def _on_training_end(self):
        self.rate = (self.num_timesteps - self.first) / (time.perf_counter() - self.started)

    def _on_step(self):
        return True


def make_model(arguments):
    environments = sb3_environments.make(arguments.task, arguments.envs, arguments.vectorisation)
    return SAC(
        "MlpPolicy", environments, device="cpu", seed=1,
        policy_kwargs={"net_arch": {"pi": arguments.hidden, "qf": arguments.critic_hidden}, "activation_fn": torch.nn.Tanh},
        train_freq=(arguments.steps_between // arguments.envs, "step"), gradient_steps=1, batch_size=arguments.batch,
        learning_starts=1024, buffer_size=1_000_000, learning_rate=1e-3, gamma=0.975, tau=0.05)


def main():
    arguments = parse_arguments()
    torch.set_num_threads(arguments.threads)
    warm_up = 2048
    model, timer = make_model(arguments), Timer(warm_up)
    model.learn(warm_up + arguments.steps, callback=timer)
    model.get_env().close()
    print(json.dumps({
        "steps_per_second": timer.rate,
        "gradient_samples_per_step": model._n_updates * arguments.batch / (model.num_timesteps - 1024),
        "stable_baselines3": importlib.metadata.version("stable_baselines3"),
        "metaworld": importlib.metadata.version("metaworld"),
        "mujoco": importlib.metadata.version("mujoco"),
    }))


if __name__ == "__main__":
    main()
