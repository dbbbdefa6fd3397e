#!/usr/bin/env python3
"""PPO in PyTorch on EnvPool: Metronome's network, batch and hyperparameters, nothing of its code.

Steps a second end to end (acting, environment, resets, learning) over the timed updates; one update
before them is warm-up. Prints one JSON object.
"""

import argparse
import json
import sys
import time

import numpy as np
import torch

import envpool_tasks
import torch_network

HORIZON = envpool_tasks.HORIZON
DISCOUNT, GAE_LAMBDA = 0.99, 0.95


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True)
    parser.add_argument("--updates", type=int, default=12, help="timed, after one of warm-up (default 12)")
    parser.add_argument("--threads", type=int, default=2, help="of PyTorch while it learns (default 2)")
    parser.add_argument("--acting-threads", type=int, default=1, help="of PyTorch while it acts (default 1)")
    parser.add_argument("--envs", type=int, default=16, help="episodes played at once and per update (default 16)")
    parser.add_argument("--env-threads", type=int, default=2, help="of EnvPool (default 2)")
    parser.add_argument("--width", type=int, default=128)
    parser.add_argument("--heads", type=int, default=10)
    parser.add_argument("--minibatch", type=int, default=1000)
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--total-steps", type=int, default=1_500_000, help="the learning rate falls over these")
    parser.add_argument("--optimizer", choices=["fused", "foreach", "loop"], default="fused")
    parser.add_argument("--compile", action="store_true", help="torch.compile the loss")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


class RunningStatistics:
    """Mean and variance of all rows seen so far."""

    def __init__(self, size):
        self.count, self.mean, self.m2 = 0, np.zeros(size), np.zeros(size)

    def merge(self, rows):
        mean, count = rows.mean(0), len(rows)
        delta, total = mean - self.mean, self.count + count
        self.mean = self.mean + delta * count / total
        self.m2 = self.m2 + rows.var(0) * count + delta**2 * self.count * count / total
        self.count = total

    def inverse_deviation(self):
        return np.ones_like(self.m2) if self.count == 0 else 1 / np.sqrt(self.m2 / self.count + 1e-8)


class Collector:
    """Plays one episode in each environment and makes a batch of them."""

    def __init__(self, arguments, agent):
        self.agent, self.envs = agent, arguments.envs
        self.environment = envpool_tasks.make(
            arguments.task, num_envs=arguments.envs, num_threads=arguments.env_threads, seed=arguments.seed)
        self.head_of_step = torch_network.head_of_step(arguments.heads, HORIZON)
        self.statistics, self.return_statistics = RunningStatistics(torch_network.OBSERVATION), RunningStatistics(1)
        # [T, envs, ...]: filled anew by every batch.
        self.observation = np.empty((HORIZON, self.envs, torch_network.OBSERVATION), np.float32)
        self.input = torch.empty(HORIZON, self.envs, torch_network.OBSERVATION)
        self.action = torch.empty(HORIZON, self.envs, torch_network.ACTION)
        self.reward = np.empty((HORIZON, self.envs), np.float32)
        self.success = np.empty((HORIZON, self.envs), bool)
        self.reset()

    def reset(self):
        self.first_observation, _ = self.environment.reset()

    def play(self):
        """Fills the arrays; log-probabilities and values wait for one large pass afterwards."""
        mean = torch.from_numpy(self.statistics.mean.astype(np.float32))
        inverse_deviation = torch.from_numpy(self.statistics.inverse_deviation().astype(np.float32))
        with torch.inference_mode():
            noise = torch.randn_like(self.action)
            noise *= self.agent.log_std.exp()[self.head_of_step][:, None]
            raw = torch.from_numpy(self.observation)
            heads = self.head_of_step.tolist()
            observation = self.first_observation
            for t in range(HORIZON):
                self.observation[t] = observation
                torch.sub(raw[t], mean, out=self.input[t])
                self.input[t].mul_(inverse_deviation).clamp_(-10, 10)
                torch.add(self.agent.actor.forward_one_head(self.input[t], heads[t]), noise[t], out=self.action[t])
                clipped = self.action[t].clamp(-1, 1).numpy()
                observation, self.reward[t], _, _, info = self.environment.step(clipped)
                self.success[t] = info["success"]
            assert (info["elapsed_step"] == HORIZON).all()

    def scaled_reward(self):
        """The reward, divided by the running deviation of the discounted return."""
        discounted, running = np.empty((HORIZON, self.envs)), np.zeros(self.envs)
        for t in range(HORIZON):
            running = running * DISCOUNT + self.reward[t]
            discounted[t] = running
        self.return_statistics.merge(discounted.reshape(-1, 1))
        return self.reward * np.float32(self.return_statistics.inverse_deviation()[0])

    def batch(self):
        """Plays, and resets for the next one."""
        self.play()
        self.reset()
        head = self.head_of_step.repeat_interleave(self.envs)
        input, action = self.input.flatten(0, 1), self.action.flatten(0, 1)
        with torch.no_grad():
            mean = self.agent.actor(input, self.agent.actor.columns(head))
            log_probability = torch_network.log_probability(action, mean, self.agent.log_std[head])
            value = self.agent.critic(input, self.agent.critic.columns(head)).view(HORIZON, self.envs).numpy()
        advantage = generalised_advantages(self.scaled_reward(), value)
        self.statistics.merge(self.observation.reshape(-1, torch_network.OBSERVATION).astype(np.float64))
        flat = [torch.from_numpy(values).flatten() for values in (advantage, advantage + value)]
        return torch_network.Batch(self.agent, input, action, log_probability, *flat, head)


def generalised_advantages(reward, value):
    """[T, envs]; nothing comes after step T."""
    advantage, carry, next_value = np.empty_like(reward), 0, 0
    for t in reversed(range(len(reward))):
        carry = reward[t] + DISCOUNT * next_value - value[t] + DISCOUNT * GAE_LAMBDA * carry
        advantage[t], next_value = carry, value[t]
    return advantage


def train(arguments):
    agent = torch_network.Agent(arguments.width, arguments.heads)
    optimizer = torch_network.make_optimizer(agent, kind=arguments.optimizer)
    loss_of = torch.compile(torch_network.ppo_loss) if arguments.compile else torch_network.ppo_loss
    collector = Collector(arguments, agent)
    steps = arguments.envs * HORIZON
    collecting, learning, returns, successes, divergences = 0, 0, [], [], []
    for update in range(arguments.updates + 1):
        rate = 5e-4 * max(0.1, 1 - update * steps / arguments.total_steps)
        optimizer.param_groups[0]["lr"] = rate
        started = time.perf_counter()
        torch.set_num_threads(arguments.acting_threads)
        batch = collector.batch()
        collected = time.perf_counter()
        torch.set_num_threads(arguments.threads)
        divergences.append(torch_network.learn(agent, optimizer, batch, arguments.minibatch, arguments.epochs, loss_of))
        learnt = time.perf_counter()
        if update > 0:
            collecting, learning = collecting + collected - started, learning + learnt - collected
        returns.append(float(collector.reward.sum(0).mean()))
        successes.append(float(collector.success.any(0).mean()))
        print(f"update {update} return {returns[-1]:.1f} success {successes[-1]:.2f} kl {divergences[-1]:.4f} "
              f"collected in {collected - started:.2f} s, learnt in {learnt - collected:.2f} s", file=sys.stderr)
    return {
        "steps_per_second": arguments.updates * steps / (collecting + learning),
        "collecting_share": collecting / (collecting + learning),
        "returns": [round(value, 1) for value in returns],
        "successes": [round(value, 3) for value in successes],
        "divergences": [round(value, 4) for value in divergences],
    }


def main():
    arguments = parse_arguments()
    torch.manual_seed(arguments.seed)
    result = train(arguments)
    result["torch"] = torch.__version__
    print(json.dumps(result))


if __name__ == "__main__":
    main()
