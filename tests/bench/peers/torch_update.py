#!/usr/bin/env python3
"""Speed of PyTorch's PPO update alone, on synthetic data: samples a second (a sample counts once per
epoch), median over repetitions. Prints one JSON object, with the matrix product's own speed beside it."""

import argparse
import json
import statistics
import time

import torch

import torch_network


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--width", type=int, default=128, help="of the tanh layers (default 128)")
    parser.add_argument("--heads", type=int, default=10)
    parser.add_argument("--minibatch", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=8000, help="in the batch (default 8000)")
    parser.add_argument("--epochs", type=int, default=10)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repetitions", type=int, default=5, help="updates timed, after one of warm-up (default 5)")
    parser.add_argument("--optimizer", choices=["fused", "foreach", "loop"], default="fused")
    parser.add_argument("--compile", action="store_true", help="torch.compile the loss")
    return parser.parse_args()


def synthetic_batch(agent, samples, heads):
    input = torch.randn(samples, torch_network.OBSERVATION)
    head = torch_network.head_of_step(heads, samples)
    with torch.inference_mode():
        mean = agent.actor(input, agent.actor.columns(head))
        log_std = agent.log_std.index_select(0, head)
        action = mean + log_std.exp() * torch.randn_like(mean)
        log_probability = torch_network.log_probability(action, mean, log_std)
    tensors = (input, action, log_probability, torch.randn(samples), torch.randn(samples), head)
    return torch_network.Batch(agent, *(tensor.clone() for tensor in tensors))


def seconds_of(function, repetitions):
    """Of each repetition, after one of warm-up."""
    seconds = []
    for _ in range(repetitions + 1):
        started = time.perf_counter()
        function()
        seconds.append(time.perf_counter() - started)
    return seconds[1:]


def gemm_gflops():
    """Of torch.mm, 1024 x 1024, float32: the best of 20."""
    a, b, out = torch.randn(1024, 1024), torch.randn(1024, 1024), torch.empty(1024, 1024)
    return 2 * 1024**3 / min(seconds_of(lambda: torch.mm(a, b, out=out), 20)) / 1e9


def main():
    arguments = parse_arguments()
    torch.manual_seed(1)
    torch.set_num_threads(arguments.threads)
    agent = torch_network.Agent(arguments.width, arguments.heads)
    optimizer = torch_network.make_optimizer(agent, kind=arguments.optimizer)
    loss_of = torch.compile(torch_network.ppo_loss) if arguments.compile else torch_network.ppo_loss
    batch = synthetic_batch(agent, arguments.samples, arguments.heads)
    seconds = seconds_of(
        lambda: torch_network.learn(agent, optimizer, batch, arguments.minibatch, arguments.epochs, loss_of),
        arguments.repetitions)
    print(json.dumps({
        "samples_per_second": arguments.samples * arguments.epochs / statistics.median(seconds),
        "gemm_gflops": gemm_gflops(),
        "torch": torch.__version__,
    }))


if __name__ == "__main__":
    main()
