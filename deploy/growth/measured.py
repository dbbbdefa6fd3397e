"""The inputs of the simulation: medians of results/performance/*.csv, in seconds, bytes and counts."""

import csv
import dataclasses
import statistics
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[2] / "results" / "performance"
ENGINE = "3.3.0"  # the faster one: more episodes a core, so growth ends earlier
# tests/bench/suite/training.py: 13 updates of 16 episodes of 500 steps, 10 epochs, minibatch 1000.
TRAINED_STEPS, TRAINED_EPOCHS = 13 * 8000, 10
STEPS = 500  # an episode's
EPISODE_BYTES = 92_000
# One version of 2x128 with ten heads (idl/metronome.idl, common/policy/network.h): the actor's parameters; and
# actor and critic, what learners would have to sum.
ACTOR_BYTES, ALL_BYTES = 4 * 26_832, 4 * 49_754
CROWD_BATCH = 1024  # tests/bench/suite/crowd.py
GROUPS = 32  # of a minibatch's samples (learner/network/mlp.h): a machine takes whole ones


class MissingFigure(Exception):
    """A file or a row that the simulation needs is not there."""


class Figures:
    """Medians over the rounds of one CSV file."""

    def __init__(self, name, folder=RESULTS):
        self.path = folder / f"{name}.csv"
        try:
            with open(self.path, newline="") as file:
                self.rows = list(csv.DictReader(file))
        except OSError as error:
            raise MissingFigure(f"{error}; measure it with tests/bench/run {name} --out {folder}") from None

    def __call__(self, case, quantity, engine=None):
        values = [float(row["value"]) for row in self.rows
                  if row["case"] == case and row["quantity"] == quantity and engine in (None, row["engine"])]
        if not values:
            raise MissingFigure(f"{self.path} has no '{quantity}' of '{case}'; measure it anew with tests/bench/run")
        return statistics.median(values)


@dataclasses.dataclass(frozen=True)
class Costs:
    """Of one task; seconds are of one core."""

    step: float  # playing one step: physics, reset, policy, rollout
    variation: float  # standard deviation of an episode's duration over its mean
    sample: float  # learning from one sample once, on one thread
    minibatch: float  # of each minibatch, however many threads there are
    handle: float  # one episode in the coordinator's thread, beside its check
    check: float  # one whole episode
    receive: float  # one episode in the middleware's receiving thread
    assignment: float  # one episode's assignment, for each participant, in the coordinator's thread
    fanout: float  # the same, in the middleware's threads: gaps, heartbeats, acknowledgements
    presence: float  # a second, for each participant
    join: float  # once, for each participant
    broadcast: float  # one version, for each participant


def slope(figures, quantity, crowds=(1, 64)):
    """How much more each further actor process costs."""
    few, many = (figures(f"{actors} actors", quantity) for actors in crowds)
    return (many - few) / (crowds[1] - crowds[0])


def read(task="push", engine=ENGINE, folder=RESULTS):
    """@throws MissingFigure naming the file and what measures it."""
    training, learner, growth, transport, crowd = (
        Figures(name, folder) for name in ("training", "learner", "growth", "transport", "crowd"))
    played = sum(training(task, f"CPU {use}", engine) for use in ("physics", "reset", "policy", "rollout"))
    update = training(task, "CPU update", engine) / (TRAINED_STEPS * TRAINED_EPOCHS)
    one, two = (1000 / learner(f"2x128, minibatch 1000, {threads}", "ours") for threads in ("1 thread", "2 threads"))
    # A learner's whole time for an episode, with one step in twenty and with all of them checked.
    some, all_ = (1 / growth(f"udp, 1 x 256, check {share}", "episodes") for share in ("0.05", "1"))
    check = (all_ - some) / (1 - 0.05)
    # 64 participants against one of 64 envs: on two cores that actors share, so rather too much.
    crowded = statistics.mean(
        (1 / growth(f"udp, 64 x 1, check {share}", "episodes") - 1 / growth(f"udp, 1 x 64, check {share}", "episodes"))
        / 63 for share in ("0.05", "1"))
    join = 1e-3 * slope(crowd, "start and joining, learner")
    fanout = 1e-3 * slope(crowd, "episode, wire") - join / CROWD_BATCH
    return Costs(
        step=played / TRAINED_STEPS,
        variation=crowd(f"{task} played", "variation"),
        sample=update,
        minibatch=2 * two - one,  # one = serial + work, two = serial + work / 2
        handle=some - 0.05 * check,
        check=check,
        receive=1e-3 * transport("udp, flat out", "learner"),
        assignment=crowded,
        fanout=max(0.0, fanout - crowded),
        presence=1e-3 * slope(crowd, "presence, learner"),
        join=join,
        broadcast=1e-3 * slope(crowd, "version, learner"),
    )
