"""Metronome's SAC update in plain PyTorch, from the definitions of its losses: what learner/README.md and
learner/sac say in words, in any precision, as fast as eager mode gets on a CPU.

Actor, critics and temperatures have a head for each block of time. Values are distributions over bins
of symlog. Heads learn from each other: a head is a part that all share plus a part of its own.
"""

import math

import torch
from torch.nn import functional


class HeadRows:
    """Where samples lie once each head has equally many rows, so that one batched product serves all
    heads. Heads with fewer samples have rows that nobody reads."""

    def __init__(self, head, heads):
        """head: [B]"""
        counts = torch.bincount(head, minlength=heads)
        self.heads, self.size = heads, int(counts.max())
        order = torch.argsort(head, stable=True)
        first = torch.cumsum(counts, 0) - counts
        self.of_sample = torch.empty_like(head)  # [B]
        self.of_sample[order] = head[order] * self.size + torch.arange(len(head)) - first[head[order]]
        self.sample = torch.zeros(heads * self.size, dtype=torch.long)
        self.sample[self.of_sample] = torch.arange(len(head))


class Networks:
    """Equal networks side by side: tanh layers (normalised: of sums divided by their root mean square), then a
    layer a head.

    hidden: [(weight [N, inputs, outputs], bias [N, outputs])], a pair a layer; head: such a pair too,
    [N, heads, inputs, outputs] and [N, heads, outputs].
    """

    def __init__(self, hidden, head, shares, normalised=False):
        self.normalised = normalised
        self.hidden = [tensor.requires_grad_() for layer in hidden for tensor in layer]
        self.own = [tensor.requires_grad_() for tensor in head]
        self.shared = [torch.zeros_like(tensor[:, :1]).requires_grad_() for tensor in head] if shares else []

    def weights(self):
        """All weights and biases as forward() takes them: those of the hidden layers, then of heads."""
        if not self.shared:
            return self.own_parameters()
        return [*self.hidden, *(own + shared for own, shared in zip(self.own, self.shared))]

    def own_parameters(self):
        return [*self.hidden, *self.own]


def forward(weights, x, rows, normalised=False):
    """[N, B, outputs] of x [B, inputs], each sample by its head; normalised: as Networks."""
    *hidden, weight, bias = weights
    networks = len(weight)
    x = x.expand(networks, *x.shape)
    for w, b in zip(hidden[::2], hidden[1::2]):
        x = torch.baddbmm(b[:, None], x, w)
        x = torch.tanh(functional.rms_norm(x, x.shape[-1:], eps=1e-5) if normalised else x)
    if rows.heads == 1:
        return torch.baddbmm(bias[:, 0, None], x, weight[:, 0])
    x = x.index_select(1, rows.sample).view(networks * rows.heads, rows.size, -1)
    y = torch.baddbmm(bias.flatten(0, 1)[:, None], x, weight.flatten(0, 1))
    return y.view(networks, rows.heads * rows.size, -1).index_select(1, rows.of_sample)


class ValueBins:
    """Values as distributions over equally spaced bins of symlog(x) = sign(x) ln(1 + |x|)."""

    def __init__(self, bins, limit, dtype):
        self.limit, self.width = limit, 2 * limit / (bins - 1)
        self.bins = torch.linspace(-limit, limit, bins, dtype=dtype)

    def value(self, logits):
        """The mean, in symlog."""
        return torch.softmax(logits, -1) @ self.bins

    @staticmethod
    def decode(value):
        return value.sign() * torch.expm1(value.abs())

    def cross_entropy(self, logits, target):
        """[N, B] of logits [N, B, bins]; a target [B] lies on the two bins around it, which average to it."""
        symlog = target.sign() * torch.log1p(target.abs())
        at = (symlog.clamp(-self.limit, self.limit) + self.limit) / self.width
        low = at.floor().clamp(max=len(self.bins) - 2)
        share = torch.stack([1 - (at - low), at - low], -1)
        bins = torch.stack([low, low + 1], -1).long().expand(*logits.shape[:-1], 2)
        return -(torch.log_softmax(logits, -1).gather(-1, bins) * share).sum(-1)


def act(output, noise):
    """(action, log-density [B]) of a squashed Gaussian, whose log-std lies between -5 and 2."""
    mean, log_std = output.chunk(2, -1)
    log_std = -5 + 3.5 * (torch.tanh(log_std) + 1)
    drawn = mean + log_std.exp() * noise
    log_slope = 2 * (math.log(2) - drawn - functional.softplus(-2 * drawn))  # of tanh
    log_density = -0.5 * noise.square() - log_std - 0.5 * math.log(2 * math.pi) - log_slope
    return torch.tanh(drawn), log_density.sum(-1)


class Optimiser:
    """Adam with a clip by the norm of the networks' own gradients."""

    def __init__(self, networks, learning_rate, settings):
        self.networks, self.clip = networks, settings["max_gradient_norm"]
        self.first_rate, self.heads_decay = learning_rate, settings["shared_heads_decay"]
        self.parameters = [*networks.own_parameters(), *networks.shared]
        self.adam = make_adam(self.parameters, learning_rate, settings)

    def descend(self, loss, share):
        """share: of the first step's learning rate."""
        self.adam.param_groups[0]["lr"] = share * self.first_rate
        self.adam.zero_grad(set_to_none=True)
        loss.backward(inputs=self.parameters)
        norm = torch.nn.utils.get_total_norm([parameter.grad for parameter in self.networks.own_parameters()])
        torch.nn.utils.clip_grads_with_norm_(self.parameters, self.clip, norm)
        self.adam.step()
        if self.networks.shared:
            self.fade(min(1.0, share * self.first_rate * self.heads_decay))

    @torch.no_grad()
    def fade(self, decay):
        """What sets a head apart from the heads' mean."""
        for own in self.networks.own:
            own.lerp_(own.mean(1, keepdim=True), decay)


def make_adam(parameters, learning_rate, settings):
    return torch.optim.Adam(parameters, lr=learning_rate, eps=settings["adam_epsilon"], fused=True)


class Batch:
    """A gradient step's samples, one row each, and what is asked of their heads."""

    def __init__(self, heads, critic_heads, *, state, value_state, action, reward, discount, head, next_state,
                 next_value_state, next_head):
        """value_state: as the critics see it, without the action."""
        self.state, self.value_state, self.action = state, value_state, action
        self.reward, self.discount, self.head = reward, discount, head
        self.next_state, self.next_value_state = next_state, next_value_state
        self.rows, self.next_rows = HeadRows(head, heads), HeadRows(next_head, heads)
        one = critic_heads == 1 < heads
        self.value_rows = HeadRows(torch.zeros_like(head), 1) if one else self.rows
        self.next_value_rows = HeadRows(torch.zeros_like(head), 1) if one else self.next_rows
        share = functional.one_hot(head, heads).to(reward.dtype)
        self.mean_of_head = (share / share.sum(0)).T.contiguous()  # [heads, B]


class Update:
    """settings: the configuration's group `sac`; run_steps: gradient steps of the whole run."""

    def __init__(self, settings, run_steps, actor, critics, log_temperature):
        self.settings, self.run_steps, self.actor, self.critics = settings, run_steps, actor, critics
        self.made = 0
        self.log_temperature = log_temperature
        self.targets = [weight.detach().clone() for weight in critics.weights()]
        self.bins = ValueBins(settings["bins"], settings["value_limit"], log_temperature.dtype)
        self.of_actor = Optimiser(actor, settings["actor_learning_rate"], settings)
        self.of_critics = Optimiser(critics, settings["critic_learning_rate"], settings)
        self.of_temperature = make_adam([log_temperature], settings["temperature_learning_rate"], settings)

    def step(self, batch, next_noise, noise):
        """One gradient step; the noise [B, action] is of the actions tried in the next states and in the states."""
        share = max(self.settings["learning_rate_floor"], 1 - self.made / self.run_steps)
        self.of_critics.descend(self.critic_loss(batch, next_noise), share)
        critics = [weight.detach() for weight in self.critics.weights()]
        torch._foreach_lerp_(self.targets, critics, self.settings["target_rate"])
        loss, entropy = self.actor_loss(batch, noise, critics)
        self.of_actor.descend(loss, share)
        self.log_temperature.grad = self.temperature_gradient(batch, entropy)
        self.of_temperature.param_groups[0]["lr"] = share * self.settings["temperature_learning_rate"]
        self.of_temperature.step()
        self.made += 1

    def values(self, weights, x, rows):
        """The critics' logits."""
        return forward(weights, x, rows, self.critics.normalised)

    def critic_loss(self, batch, noise):
        with torch.no_grad():
            action, _ = act(forward(self.actor.weights(), batch.next_state, batch.next_rows)[0], noise)
            next_input = torch.cat([batch.next_value_state, action], 1)
            value = self.bins.value(self.values(self.targets, next_input, batch.next_value_rows)).amin(0)
            target = batch.reward + batch.discount * self.bins.decode(value)
        logits = self.values(self.critics.weights(), torch.cat([batch.value_state, batch.action], 1), batch.value_rows)
        return self.bins.cross_entropy(logits, target).mean(1).sum()

    def actor_loss(self, batch, noise, critics):
        """(loss, entropy of each sample)"""
        action, log_density = act(forward(self.actor.weights(), batch.state, batch.rows)[0], noise)
        value = self.bins.value(self.values(critics, torch.cat([batch.value_state, action], 1), batch.value_rows))
        temperature = self.log_temperature.exp().index_select(0, batch.head)
        return (temperature * log_density - value.amin(0)).mean(), -log_density.detach()

    def temperature_gradient(self, batch, entropy):
        """Of ln(temperature) * (entropy - that of a Gaussian of the wanted std), for each head."""
        actions = batch.action.shape[1]
        wanted = actions * (0.5 + 0.5 * math.log(2 * math.pi) + math.log(self.wanted_std()))
        return batch.mean_of_head @ entropy - wanted

    def wanted_std(self):
        """Falls from target_std to final_target_std, by the same factor a step, for target_std_decay of the run."""
        first, last = self.settings["target_std"], self.settings["final_target_std"]
        falling = self.settings["target_std_decay"] * self.run_steps
        return first * (last / first)**min(1, self.made / falling) if falling else first
