"""A run in virtual time: actors' envs, assignments, links, the learner's threads, the update, new weights.

What it leaves out: failures and assignments repeated because of them, the audit, the disk, actors that
share cores with the learner (but for the update, which then has their cores to itself: overlap 0).
"""

import collections
import dataclasses
import heapq
import math
import random

import simpy

from measured import ACTOR_BYTES, ALL_BYTES, EPISODE_BYTES, GROUPS, STEPS

LATENCY = 1e-4  # seconds, one way


@dataclasses.dataclass(frozen=True)
class Plan:
    """The use of each core. An env plays on a core of its own."""

    cores: int  # that play
    envs: int = 1  # of an actor process; a participant each
    gigabits: float = 10  # the learner's link, each way
    threads: int = 16  # of the update, on cores that nothing else uses
    episodes: int = 16  # E
    minibatches: int = 8  # of an epoch
    epochs: int = 10
    overlap: int = 0
    check_share: float = 1
    # These are not built: see growth.md.
    checkers: int = 0  # threads that check beside the coordinator's
    intakes: int = 1  # threads that receive and coordinate, each a share of the numbers
    relay: int = 0  # actor processes behind one relay, which alone is a participant of the learner
    narrow_assignments: bool = False  # an assignment reaches its actor alone
    learners: int = 1  # machines of `threads` each that share every batch
    exchange: float = 5e-5  # seconds: latency of one message between them

    @property
    def actors(self):
        return math.ceil(self.cores / self.envs)

    @property
    def participants(self):
        """That each learner sees."""
        seen = math.ceil(self.actors / self.learners)
        return math.ceil(seen / self.relay) if self.relay else seen


def minibatch_seconds(plan, costs):
    """Machines share out whole groups of samples, threads all the work of one. Then sums are exchanged."""
    size = plan.episodes * STEPS // plan.minibatches
    share = math.ceil(GROUPS / plan.learners) / GROUPS
    work = size * costs.sample - costs.minibatch
    seconds = costs.minibatch + work * share / plan.threads
    if plan.learners > 1:
        # Every machine adds its part of the parameters, in the order of the groups, and hands it on:
        # sums of one group a machine cross twice, in log2 rounds each way.
        rounds = 2 * math.ceil(math.log2(plan.learners))
        crossing = 2 * ALL_BYTES * 8 / (plan.gigabits * 1e9) * (plan.learners - 1) / plan.learners
        seconds += rounds * plan.exchange + crossing
    return seconds


def update_seconds(plan, costs):
    return plan.epochs * plan.minibatches * minibatch_seconds(plan, costs)


class Server:
    """First come, first served, by `count` equal servers; a service's length is known at its start."""

    def __init__(self, env, count=1):
        self.env, self.count, self.busy = env, count, 0.0
        self._free = [0.0] * count

    def serve(self, seconds, wait=0.0):
        """@param wait  until the customer is there. @return how long from now until it is done."""
        begin = max(self.env.now + wait, heapq.heappop(self._free))
        heapq.heappush(self._free, begin + seconds)
        self.busy += seconds
        return begin + seconds - self.env.now


class Actor:
    """`assignments` as the learner counts them: until their episode has arrived."""

    def __init__(self, envs):
        self.envs, self.assignments, self.playing, self.waiting = envs, 0, 0, collections.deque()


class Run:
    """The rules of learner/collect/assignments/assignment_plan.h without what only failures need: lowest numbers first to
    the least loaded, two assignments an env, one near the end, batches up to `overlap` ahead of the weights."""

    def __init__(self, plan, costs, seed):
        self.plan, self.costs = plan, costs
        self.env = simpy.Environment()
        self.random = random.Random(seed)
        self.actors = [Actor(min(plan.envs, plan.cores - i * plan.envs)) for i in range(plan.actors)]
        self.load = [(0.0, i) for i in range(len(self.actors))]  # heap; old entries are skipped
        self.open = collections.deque()  # the batch of each number to hand out, lowest first
        self.next_batch = self.version = 0
        self.accepted = {}  # of batch
        self.updating = False
        self.weights_at = 0.0  # when all actors have the newest
        self.updates = []  # times of their ends
        machines = plan.learners
        rate = plan.gigabits * 1e9 / 8
        self.link_in, self.link_out = Server(self.env, machines), Server(self.env, machines)
        self.episode_on_link, self.version_on_link = EPISODE_BYTES / rate, ACTOR_BYTES / rate
        self.receiver = Server(self.env, plan.intakes * machines)
        self.coordinator = Server(self.env, plan.intakes * machines)
        self.checkers = Server(self.env, plan.checkers * machines) if plan.checkers else None
        self.update = Server(self.env)
        self.playing = 0.0  # env seconds
        heard = 1 if plan.narrow_assignments else plan.participants
        self.receiving = costs.receive + heard * costs.fanout
        self.handling = costs.handle + heard * costs.assignment
        self.checking = costs.check * plan.check_share

    def after(self, seconds, action, *arguments):
        self.env.timeout(seconds).callbacks.append(lambda _: action(*arguments))

    def run(self, updates):
        self.open_batches()
        self.plan_assignments()
        while len(self.updates) < updates:
            self.env.step()

    # --- Assignments ---------------------------------------------------------------------------------

    def open_batches(self):
        while self.next_batch <= self.version + self.plan.overlap:
            self.open.extend([self.next_batch] * self.plan.episodes)
            self.accepted[self.next_batch] = 0
            self.next_batch += 1

    def plan_assignments(self):
        while self.open:
            index = self.least_loaded(1 if len(self.open) <= self.plan.cores else 2)
            if index is None:
                return
            self.actors[index].assignments += 1
            self.note_load(index)
            self.after(LATENCY, self.assignment, self.actors[index], index, self.open.popleft())

    def least_loaded(self, assignments_per_env):
        """@return an actor that takes another assignment, or None."""
        while self.load:
            load, index = self.load[0]
            if load != self.load_of(index):
                heapq.heappop(self.load)
            else:
                return index if load < assignments_per_env else None
        return None

    def load_of(self, index):
        return self.actors[index].assignments / self.actors[index].envs

    def note_load(self, index):
        heapq.heappush(self.load, (self.load_of(index), index))

    # --- Actors ---------------------------------------------------------------------------------

    def assignment(self, actor, index, batch):
        actor.waiting.append(batch)
        self.play(actor, index)

    def play(self, actor, index):
        while actor.playing < actor.envs and actor.waiting:
            batch = actor.waiting.popleft()
            actor.playing += 1
            mean = STEPS * self.costs.step
            seconds = max(0.2 * mean, self.random.gauss(mean, self.costs.variation * mean))
            # Only the newest weights may not have come yet.
            is_newest = batch - min(batch, self.plan.overlap) == self.version
            wait = max(0.0, self.weights_at - self.env.now) if is_newest else 0.0
            self.after(wait + seconds, self.played, actor, index, batch, seconds)

    def played(self, actor, index, batch, seconds):
        actor.playing -= 1
        self.playing += seconds
        arrival = self.link_in.serve(self.episode_on_link, LATENCY)
        self.after(self.receiver.serve(self.receiving, arrival), self.take, index, batch)
        self.play(actor, index)

    # --- Learner --------------------------------------------------------------------------------

    def take(self, index, batch):
        """New assignments go out before the check."""
        check = 0.0 if self.checkers else self.checking
        done = self.coordinator.serve(self.handling + check)
        self.after(done - check, self.arrive, index)
        if self.checkers:
            self.after(done, self.check_elsewhere, batch)
        else:
            self.after(done, self.accept, batch)

    def arrive(self, index):
        self.actors[index].assignments -= 1
        self.note_load(index)
        self.plan_assignments()

    def check_elsewhere(self, batch):
        self.after(self.checkers.serve(self.checking), self.accept, batch)

    def accept(self, batch):
        self.accepted[batch] += 1
        self.update_if_complete()

    def update_if_complete(self):
        if self.updating or self.accepted.get(self.version) != self.plan.episodes:
            return
        self.updating = True
        self.after(self.update.serve(update_seconds(self.plan, self.costs)), self.publish)

    def publish(self):
        self.updating = False
        del self.accepted[self.version]
        self.version += 1
        self.updates.append(self.env.now)
        # Sent to one participant after the other by the coordinator's thread, before the assignments.
        said = self.coordinator.serve(self.plan.participants * self.costs.broadcast)
        through = self.link_out.serve(self.plan.participants * self.version_on_link)
        self.weights_at = self.env.now + max(said, through) + LATENCY
        self.open_batches()
        self.after(said, self.plan_assignments)
        self.update_if_complete()


@dataclasses.dataclass(frozen=True)
class Outcome:
    steps_per_second: float
    idle: float  # share of the envs' time
    loads: dict  # {part: share of its time that it is busy}

    @property
    def limit(self):
        """The busiest part."""
        return max(self.loads, key=self.loads.get)


def simulate(plan, costs, updates=6, seed=1):
    """The outcome from the second of `updates` updates on; the first fills the pipes."""
    run = Run(plan, costs, seed)
    run.run(1)
    begin, played = run.env.now, run.playing
    servers = {"link in": run.link_in, "link out": run.link_out, "receiver": run.receiver,
               "coordinator and check": run.coordinator, "update": run.update}
    if run.checkers:
        servers["checkers"] = run.checkers
    busy = {name: server.busy for name, server in servers.items()}
    run.run(updates)
    seconds = run.env.now - begin
    loads = {name: (server.busy - busy[name]) / seconds / server.count for name, server in servers.items()}
    loads["actors"] = (run.playing - played) / seconds / plan.cores
    # Leases, announcements and statuses: threads of their own, with a core.
    loads["presence"] = plan.participants * costs.presence
    steps = (updates - 1) * plan.episodes * STEPS
    return Outcome(steps / seconds, max(0.0, 1 - loads["actors"]), loads)
