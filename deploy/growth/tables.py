"""The tables of growth.md: {name: function of costs and the most cores to simulate, giving Markdown}."""

import dataclasses
import math

from measured import ACTOR_BYTES, EPISODE_BYTES, STEPS, Figures
from model import Plan, minibatch_seconds, simulate

PRESETS = {  # README.md, deploy/wide.textproto
    "default": dict(episodes=16, minibatches=8),
    "wide": dict(episodes=100, minibatches=20, overlap=1, check_share=0.05),
}


def markdown(header, lines):
    rule = "| --- |" + " ---: |" * (len(header) - 1)
    head, *body = ("| " + " | ".join(map(str, line)) + " |" for line in (header, *lines))
    return "\n".join([head, rule, *body])


def rounded(value, digits=3):
    """Three digits are more than the model is worth."""
    if value == 0:
        return "0"
    scale = 10 ** (math.floor(math.log10(abs(value))) - digits + 1)
    return f"{round(value / scale) * scale:.12g}" if scale >= 1 else f"{value:.{digits}g}"


def percent(share):
    return f"{100 * share:.0f} %"


def big(cores, **more):
    """As many machines as it takes: a process of 16 envs each, E twice the envs, 20 minibatches an
    epoch as in the wide preset."""
    return Plan(**{"cores": cores, "envs": 16, "episodes": max(16, 2 * cores), "minibatches": 20, "overlap": 1,
                   "check_share": 0.05, **more})


def updates_of(plan):
    """To simulate: few of the large ones."""
    return max(2, min(8, 20000 // plan.episodes))


# --- How far off it is ----------------------------------------------------------------------------


def measured_rates():
    """(what, measured steps/s, plan of the same)."""
    training, overlap = Figures("training"), Figures("overlap")
    alone = dict(cores=1, threads=1)
    pinned = "push, learner and actor on a core each, "
    yield ("push, two actors, learner on the same two cores",
           training("push", "Metronome", "3.3.0"), Plan(cores=2, threads=2, **PRESETS["default"]))
    yield pinned + "overlap 0", overlap("push", "overlap 0"), Plan(**alone, **PRESETS["default"])
    yield pinned + "overlap 1", overlap("push", "overlap 1"), Plan(**alone, **PRESETS["default"] | {"overlap": 1})
    yield (pinned + "wide, overlap 0", overlap("push", "wide, overlap 0"),
           Plan(**alone, **PRESETS["wide"] | {"overlap": 0}))
    yield pinned + "wide", overlap("push", "wide"), Plan(**alone, **PRESETS["wide"])


def measured_intakes():
    """(what, measured episodes/s, processes, envs, share of steps checked)."""
    growth = Figures("growth")
    for processes, envs in ((1, 1), (2, 1), (4, 1), (16, 1), (64, 1), (1, 64), (1, 256)):
        for share in ("0.05", "1"):
            case = f"udp, {processes} x {envs}, check {share}"
            yield case, growth(case, "episodes"), processes, envs, float(share)


def simulated_intake(costs, processes, envs, share):
    """Episodes a second of one batch that costs actors next to nothing to play."""
    ready = dataclasses.replace(costs, step=1e-4 / STEPS)
    plan = Plan(cores=processes * envs, envs=envs, gigabits=1000, episodes=2048, minibatches=1, epochs=0,
                check_share=share)
    return simulate(plan, ready, updates=2).steps_per_second / STEPS


def validation(costs, most_cores):
    lines = []
    for what, measured, plan in measured_rates():
        simulated = simulate(plan, costs, updates=30).steps_per_second
        lines.append([what, f"{measured:.0f} steps/s", f"{simulated:.0f}", f"{100 * (simulated / measured - 1):+.0f} %"])
    for case, measured, processes, envs, share in measured_intakes():
        simulated = simulated_intake(costs, processes, envs, share)
        lines.append([f"intake, {case}", f"{measured:.0f} episodes/s", f"{simulated:.0f}",
                      f"{100 * (simulated / measured - 1):+.0f} %"])
    return markdown(["", "measured", "simulated", "off by"], lines)


# --- What each part holds -------------------------------------------------------------------------


def capacities(costs):
    """(part, playing cores that keep it busy, its cost). Each alone, all others being free."""
    an_episode = STEPS * costs.step  # seconds of a playing core
    for threads, size in ((2, 1000), (16, 1000), (16, 2500), (64, 25000)):
        plan = Plan(cores=1, threads=threads, episodes=size // 25, minibatches=20)
        sample = minibatch_seconds(plan, costs) / size
        yield (f"update, 10 epochs, minibatch {size}, {threads} threads", costs.step / sample / 10,
               f"{1e6 * sample:.2g} us a sample and epoch")
    for share in (1, 0.05):
        seconds = costs.handle + share * costs.check
        yield (f"coordinator and check, share {share}", an_episode / seconds, f"{1e3 * seconds:.2f} ms an episode")
    for participants in (1, 16, 100, 1000):
        seconds = costs.receive + participants * costs.fanout
        yield (f"receiving, assignments heard by {participants}", an_episode / seconds, f"{1e3 * seconds:.2f} ms an episode")
    for gigabits in (1, 10, 100):
        seconds = EPISODE_BYTES * 8 / (gigabits * 1e9)
        yield f"link of {gigabits} Gbit/s", an_episode / seconds, f"{1e3 * seconds:.3g} ms an episode"
    for envs in (1, 16):
        yield (f"presence, {envs} envs a process", envs / costs.presence,
               f"{1e3 * costs.presence:.2g} ms a second and process")


def capacity(costs, most_cores):
    return markdown(["part", "playing cores", "its cost"],
                    [[part, rounded(cores, 2), cost] for part, cores, cost in capacities(costs)])


# --- What happens at 10 to 10000 cores ------------------------------------------------------------

PARTS = ["update", "coordinator and check", "receiver", "link in", "presence"]


def outcome_line(name, plan, costs):
    found = simulate(plan, costs, updates_of(plan))
    verdict = found.limit if found.loads["presence"] < 1 else f"{found.limit} (leases lapse)"
    return [name, rounded(found.steps_per_second), percent(found.idle), verdict,
            *(percent(min(9.99, found.loads[part])) for part in PARTS)]


HEADER = ["", "steps/s", "actors idle", "busiest", *PARTS]


def today(costs, most_cores):
    lines = []
    for cores in (10, 100, 1000, 10000):
        if cores > most_cores:
            continue
        lines.append(outcome_line(f"{cores} cores", big(cores), costs))
        if 10 < cores < 10000:
            lines.append(outcome_line(f"{cores} cores, 1 env a process", big(cores, envs=1), costs))
        if cores == 100:
            lines.append(outcome_line(f"{cores} cores, every step checked", big(cores, check_share=1), costs))
            lines.append(outcome_line(f"{cores} cores, 1 Gbit/s", big(cores, gigabits=1), costs))
            lines.append(outcome_line(f"{cores} cores, overlap 0", big(cores, overlap=0), costs))
    return markdown(HEADER, lines)


# --- What would answer it -------------------------------------------------------------------------

ANSWERS = {
    "64 update threads for 16": dict(threads=64),
    "8 learners for one, 100 Gbit/s, 5 us": dict(learners=8, gigabits=100, exchange=5e-6),
    "4 epochs for 10": dict(epochs=4),
    "assignments that reach their actor alone": dict(narrow_assignments=True),
    "4 intakes for one": dict(intakes=4),
}


def designs(costs, most_cores):
    """The worth of each where all others are there: without it the run is so much slower."""
    everything = {name: value for change in ANSWERS.values() for name, value in change.items()}
    relayed = everything | {"narrow_assignments": False, "relay": 16}
    cases = {"today": {}, "all of these": everything, "relays of 16 processes for such assignments": relayed}
    for answer, change in ANSWERS.items():
        cases[f"all but {answer}"] = {name: value for name, value in everything.items() if name not in change}
    sizes = [cores for cores in (100, 1000, 10000) if cores <= most_cores]
    lines = []
    for name, changes in cases.items():
        line = [name]
        for cores in sizes:
            plan = big(cores, **changes)
            found = simulate(plan, costs, updates_of(plan))
            line += [rounded(found.steps_per_second), found.limit]
        lines.append(line)
    return markdown(["", *(text for cores in sizes for text in (f"{cores} cores, steps/s", "busiest"))], lines)


def learners(costs, most_cores):
    """Of the update alone, steps a second that it can learn from."""
    lines = []
    for size in (1000, 2500, 25000, 250000):
        line = [f"{size}"]
        for network in (dict(), dict(gigabits=100, exchange=5e-6)):
            for machines in (1, 2, 8, 32):
                if machines == 1 and network:
                    continue
                plan = Plan(cores=1, episodes=size // 25, minibatches=20, learners=machines, **network)
                line.append(rounded(size / minibatch_seconds(plan, costs) / 10))
        lines.append(line)
    return markdown(["minibatch", "1 learner", "2, 10 Gbit/s", "8, 10 Gbit/s", "32, 10 Gbit/s", "2, 100 Gbit/s",
                     "8, 100 Gbit/s", "32, 100 Gbit/s"], lines)


def presence(costs, most_cores):
    lines = []
    for envs in (1, 4, 16, 64):
        line = [envs]
        for cores in (1000, 10000):
            participants = math.ceil(cores / envs)
            line += [participants, percent(participants * costs.presence), rounded(participants * costs.join, 2),
                     rounded(1e3 * participants * costs.broadcast, 2), rounded(participants * ACTOR_BYTES / 1e6, 2)]
        lines.append(line)
    return markdown(["envs a process", *(text for cores in (1000, 10000) for text in (
        f"{cores} cores: processes", "presence", "joining, s", "a version, ms", "MB"))], lines)


TABLES = {"validation": validation, "capacity": capacity, "today": today, "designs": designs, "learners": learners,
          "presence": presence}
