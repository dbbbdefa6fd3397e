#!/usr/bin/env python3
"""The gradient steps that build/bin/sac_steps --out wrote, made again by PyTorch (torch_sac.py).

Without --threads: in float64, and how far each tensor then is from ours. With it: how fast PyTorch
makes them in float32. Prints one JSON object a folder.
"""

import argparse
import json
import math
import pathlib
import statistics
import time

import numpy as np
import torch

import torch_sac


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--threads", type=int, help="measure the speed with so many")
    parser.add_argument("--steps", type=int, default=60, help="that are timed, after ten of warm-up (default 60)")
    parser.add_argument("--compile", action="store_true", help="torch.compile the losses, for the speed")
    return parser.parse_args()


class Written:
    """What sac_steps wrote into a folder."""

    def __init__(self, folder, dtype):
        self.folder, self.dtype = folder, dtype
        header = json.loads((folder / "header.json").read_text())
        self.config, self.heads = header["config"], header["heads"]
        self.layouts = {"actor": header["actor"], "critics": header["critic"]}

    def array(self, name):
        return torch.from_numpy(np.load(self.folder / f"{name}.npy"))

    def numbers(self, name):
        return self.array(name).to(self.dtype)

    def layers(self, network, name):
        """[(weight, bias)] of the network's layout in the flat array `name`; see torch_sac.Networks."""
        layout = self.layouts[network]
        flat = self.numbers(name).view(-1, layout["size"])
        layers = []
        for slice in [*layout["hidden"], layout["head"]]:
            outputs, inputs = slice["shape"]
            weight = flat[:, slice["weight"]:slice["weight"] + outputs * inputs].reshape(-1, outputs, inputs)
            layers.append((weight, flat[:, slice["bias"]:slice["bias"] + outputs].clone()))
        weight, bias = layers.pop()
        head = [tensor.unflatten(1, (layout["heads"], -1)) for tensor in (weight, bias)]
        return [(transposed(weight), bias) for weight, bias in layers], (transposed(head[0]), head[1])


def transposed(weight):
    return weight.mT.contiguous()


class Samples:
    """Batches of the replay, by the samples' places in it."""

    def __init__(self, written):
        self.config, self.heads = written.config, written.heads
        self.critic_heads = written.layouts["critics"]["heads"]
        self.observation, self.action = written.numbers("observation"), written.numbers("action")
        self.reward, self.head = written.numbers("reward"), written.array("head").long()
        self.mean, self.inv_std = written.numbers("observation_mean"), written.numbers("observation_inv_std")
        self.places = written.array("samples").long()

    def states(self, episode, t):
        """(as the actor sees it, as the critics do)"""
        policy, tasks = self.config["policy"], len(self.mean)
        task = episode % tasks
        clip = policy["observation_clip"]
        parts = [((self.observation[episode, t] - self.mean[task]) * self.inv_std[task]).clamp(-clip, clip)]
        if tasks > 1 and self.config["environment"]["task_id"] == "TASK_ID_ONEHOT":
            parts.append(torch.nn.functional.one_hot(task, tasks).to(parts[0].dtype))
        time = (2 * t.to(parts[0].dtype) / self.config["environment"]["horizon"] - 1)[:, None]
        sees_time = policy["method"] == "SINGLE_TIME"
        state = torch.cat([*parts, time] if sees_time else parts, 1)
        return state, torch.cat([state, time], 1) if policy["critic_time"] and not sees_time else state

    def rewards(self, episode, t):
        """(discounted sum of up to n rewards, the step after them, discount of the value there)"""
        sac, length = self.config["sac"], self.reward.shape[1]
        total, discount = torch.zeros_like(self.reward[episode, t]), 1.0
        for i in range(sac["n_step"]):
            inside = t + i < length
            total += sac["discount"]**i * torch.where(inside, self.reward[episode, (t + i).clamp(max=length - 1)], 0)
        after = (t + sac["n_step"]).clamp(max=length)
        discount = torch.pow(sac["discount"], (after - t).to(total.dtype))
        # All episodes end at the time limit.
        return total, after, discount if sac["time_limit_value"] == "BOOTSTRAP" else torch.where(after < length, discount, 0)

    def batch(self, step):
        episode, t = self.places[step].unbind(1)
        reward, after, discount = self.rewards(episode, t)
        state, value_state = self.states(episode, t)
        next_state, next_value_state = self.states(episode, after)
        return torch_sac.Batch(
            self.heads, self.critic_heads, state=state, value_state=value_state, action=self.action[episode, t], reward=reward,
            discount=discount, head=self.head[episode, t], next_state=next_state, next_value_state=next_value_state,
            next_head=self.head[episode, after])


def gradient_steps(config):
    """Of the whole run."""
    sac = config["sac"]
    learnt_from = int(config["total_steps"]) - sac["random_episodes"] * config["environment"]["horizon"]
    return int(sac["replay_ratio"] * learnt_from / sac["batch"])


def make_update(written):
    settings = written.config["sac"]
    actor, critics = (
        torch_sac.Networks(*written.layers(name, f"{name}_before"), settings["shared_heads"] and layout["heads"] > 1,
                           name == "critics" and settings["critic_norm"])
        for name, layout in written.layouts.items())
    update = torch_sac.Update(settings, gradient_steps(written.config), actor, critics, written.numbers("log_temperature_before").requires_grad_())
    hidden, head = written.layers("critics", "targets_before")
    for target, value in zip(update.targets, [*(tensor for layer in hidden for tensor in layer), *head]):
        target.copy_(value)
    return update


def named(hidden, head, network):
    """{name: tensor}, each network, layer and head apart."""
    tensors = {}
    for copy in range(len(head[0])):
        name = network if len(head[0]) == 1 else f"{network}[{copy}]"
        for i, (weight, bias) in enumerate(hidden):
            tensors |= {f"{name}.hidden[{i}].weight": weight[copy], f"{name}.hidden[{i}].bias": bias[copy]}
        for j, (weight, bias) in enumerate(zip(*(tensor[copy] for tensor in head))):
            tensors |= {f"{name}.head[{j}].weight": weight, f"{name}.head[{j}].bias": bias}
    return tensors


def as_layers(weights):
    *hidden, weight, bias = (tensor.detach() for tensor in weights)
    return list(zip(hidden[::2], hidden[1::2])), (weight, bias)


class WatchedBins(torch_sac.ValueBins):
    """Knows how close values of the two critics came: on a tie to rounding, policies climb one critic or the other."""

    closest = math.inf

    def value(self, logits):
        values = super().value(logits)
        self.closest = min(self.closest, float((values[0] - values[1]).detach().abs().min()))
        return values


def compare(folder):
    """{"tensors": {name: [difference to ours, how far the steps moved it], both relative to its norm}, "closest": see
    WatchedBins}"""
    torch.set_num_threads(1)
    written = Written(folder, torch.float64)
    update, samples, noise = make_update(written), Samples(written), written.numbers("noise")
    update.bins = WatchedBins(written.config["sac"]["bins"], written.config["sac"]["value_limit"], written.dtype)
    for step in range(len(noise)):
        update.step(samples.batch(step), noise[step, :, 0], noise[step, :, 1])
    theirs = {"log_temperature": update.log_temperature.detach()}
    ours, before = ({"log_temperature": written.numbers(f"log_temperature_{when}")} for when in ("after", "before"))
    for name, weights in (("actor", update.actor.weights()), ("critics", update.critics.weights()), ("targets", update.targets)):
        theirs |= named(*as_layers(weights), name)
        layout = "actor" if name == "actor" else "critics"
        ours |= named(*written.layers(layout, f"{name}_after"), name)
        before |= named(*written.layers(layout, f"{name}_before"), name)
    distances = {name: [float((other - theirs[name]).norm() / theirs[name].norm()) for other in (ours[name], before[name])]
                 for name in theirs}
    return {"tensors": distances, "closest": update.bins.closest}


def samples_per_second(folder, threads, steps, compiled):
    """Batches are ready; only noise is drawn in the time."""
    torch.set_num_threads(threads)
    written = Written(folder, torch.float32)
    update, samples = make_update(written), Samples(written)
    if compiled:
        update.critic_loss, update.actor_loss = (torch.compile(loss) for loss in (update.critic_loss, update.actor_loss))
    batches = [samples.batch(step) for step in range(len(samples.places))]
    seconds = []
    for step in range(10 + steps):
        batch = batches[step % len(batches)]
        started = time.perf_counter()
        next_noise, noise = torch.randn(2, *batch.action.shape)
        update.step(batch, next_noise, noise)
        seconds.append(time.perf_counter() - started)
    return len(batches[0].action) / statistics.median(seconds[10:])


def main():
    arguments = parse_arguments()
    for folder in arguments.folders:
        if arguments.threads is None:
            print(json.dumps(compare(folder)), flush=True)
        else:
            rate = samples_per_second(folder, arguments.threads, arguments.steps, arguments.compile)
            print(json.dumps({"samples_per_second": rate, "torch": torch.__version__}), flush=True)


if __name__ == "__main__":
    main()
