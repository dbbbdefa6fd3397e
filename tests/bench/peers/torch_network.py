"""Metronome's network and its PPO update, in plain PyTorch as fast as eager mode gets on a CPU.

Separate actor and critic, tanh MLPs whose last layer holds k heads; the time within the episode picks
the head, floor(t * k / T), and every head of the actor has a log-std of its own.
"""

import math

import torch
from torch import nn
from torch.nn import functional

OBSERVATION = 39
ACTION = 4


def head_of_step(heads, horizon):
    """[T] the head that acts at each step of an episode."""
    return torch.arange(horizon) * heads // horizon


class MultiHeadMlp(nn.Module):
    def __init__(self, inputs, width, heads, outputs, output_gain):
        super().__init__()
        self.outputs = outputs
        self.trunk = nn.Sequential(nn.Linear(inputs, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh())
        self.heads = nn.Linear(width, heads * outputs)
        for layer, gain in ((self.trunk[0], math.sqrt(2)), (self.trunk[2], math.sqrt(2)), (self.heads, output_gain)):
            nn.init.orthogonal_(layer.weight, gain)
            nn.init.zeros_(layer.bias)

    def columns(self, head):
        """[B, outputs] where each sample's own head lies in the last layer; `head` is [B]."""
        return head[:, None] * self.outputs + torch.arange(self.outputs)

    def forward(self, x, columns):
        """[B, outputs]. All heads in one product, then a gather: faster here than a product per head."""
        return self.heads(self.trunk(x)).gather(1, columns)

    def forward_one_head(self, x, head):
        """[B, outputs] where all samples belong to one head."""
        rows = slice(head * self.outputs, (head + 1) * self.outputs)
        return functional.linear(self.trunk(x), self.heads.weight[rows], self.heads.bias[rows])


class Agent(nn.Module):
    def __init__(self, width=128, heads=10, initial_log_std=-0.5):
        super().__init__()
        self.actor = MultiHeadMlp(OBSERVATION, width, heads, ACTION, 0.01)
        self.critic = MultiHeadMlp(OBSERVATION, width, heads, 1, 1.0)
        self.log_std = nn.Parameter(torch.full((heads, ACTION), float(initial_log_std)))


def log_probability(action, mean, log_std):
    """[B] of a diagonal Gaussian, less its constant, which no ratio needs."""
    z = (action - mean) * torch.exp(-log_std)
    return (z * z).sum(1).mul(-0.5) - log_std.sum(1)


class Batch:
    """The data of an update, one row a sample."""

    FIELDS = ("input", "action", "log_probability", "advantage", "target", "head", "actor_columns", "critic_columns")

    def __init__(self, agent, input, action, log_probability, advantage, target, head):
        self.input, self.action, self.log_probability = input, action, log_probability
        self.advantage, self.target, self.head = advantage, target, head
        self.actor_columns, self.critic_columns = agent.actor.columns(head), agent.critic.columns(head)

    def shuffled_minibatches(self, size):
        """One gather an epoch; the minibatches are views of it."""
        permutation = torch.randperm(len(self.head))
        shuffled = [getattr(self, name).index_select(0, permutation) for name in self.FIELDS]
        return zip(*(values.split(size) for values in shuffled))


def ppo_loss(agent, input, action, old_log_probability, advantage, target, head, actor_columns, critic_columns,
             clip=0.2, value_coefficient=0.5, entropy_coefficient=0.005):
    """(loss, log-ratio [B])"""
    advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
    log_std = agent.log_std.index_select(0, head)
    log_ratio = log_probability(action, agent.actor(input, actor_columns), log_std) - old_log_probability
    ratio = log_ratio.exp()
    policy = torch.min(ratio * advantage, ratio.clamp(1 - clip, 1 + clip) * advantage).mean()
    value = functional.mse_loss(agent.critic(input, critic_columns).squeeze(1), target)
    entropy = log_std.sum(1).mean()  # less its constant
    return 0.5 * value_coefficient * value - policy - entropy_coefficient * entropy, log_ratio


def make_optimizer(agent, learning_rate=5e-4, kind="fused"):
    """kind: fused, foreach or loop."""
    options = {"fused": {"fused": True}, "foreach": {"foreach": True}, "loop": {"foreach": False}}[kind]
    return torch.optim.Adam(agent.parameters(), lr=learning_rate, eps=1e-5, **options)


def learn(agent, optimizer, batch, minibatch, epochs, loss_of=ppo_loss, max_gradient_norm=0.5):
    """All epochs of one update; returns the KL estimate of the last minibatch."""
    parameters = list(agent.parameters())
    for _ in range(epochs):
        for samples in batch.shuffled_minibatches(minibatch):
            loss, log_ratio = loss_of(agent, *samples)
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            nn.utils.clip_grad_norm_(parameters, max_gradient_norm)
            optimizer.step()
    return -log_ratio.detach().mean().item()
