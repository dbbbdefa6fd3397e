"""Costs of the wire: processor time per episode at both ends, and the way of the weights."""

import statistics

from suite import _stats, _wire

NAME = "transport"
HELP = "processor time per episode at the actor and at the learner; latency of weights to 1, 4, 16 actors"
TRANSPORTS = ("udp", "shm")


def measure(options, record):
    for number in range(1, options.rounds + 1):
        def put(case, quantity, unit, value):
            record(case=case, quantity=quantity, unit=unit, round=number, value=value,
                   engine=options.engine)

        for transport in TRANSPORTS:
            _flat_out(options, transport, put)
            _weights(options, transport, put)
            for task in options.tasks:
                _playing(options, transport, task, put)


def _transport(options, transport, task, *arguments):
    with _wire.stage(options, NAME) as stage:
        config = _wire.config_file(stage, "--task", task)
        return _wire.result(_wire.swarm(stage, "transport", config, transport, *arguments))


def _flat_out(options, transport, put):
    cost = _transport(options, transport, options.tasks[0], "--episodes", 300 if options.quick else 6000)
    count = cost["episodes"]
    sending = cost["actor_cpu_seconds"] - cost["play_cpu_seconds"]
    put(f"{transport}, flat out", "actor", "ms CPU an episode", 1e3 * sending / count)
    put(f"{transport}, flat out", "learner", "ms CPU an episode", 1e3 * cost["learner_cpu_seconds"] / count)
    put(f"{transport}, flat out", "episodes", "1/s", count / cost["wall_seconds"])


def _playing(options, transport, task, put):
    cost = _transport(options, transport, task, "--plays", "--episodes", 3 if options.quick else 50)
    count, case = cost["episodes"], f"{transport}, {task} played"
    sending = cost["actor_cpu_seconds"] - cost["play_cpu_seconds"]
    put(case, "play", "ms CPU an episode", 1e3 * cost["play_cpu_seconds"] / count)
    put(case, "actor", "ms CPU an episode", 1e3 * sending / count)
    put(case, "learner", "ms CPU an episode", 1e3 * cost["learner_cpu_seconds"] / count)
    put(case, "share", "of the actor's CPU", sending / cost["actor_cpu_seconds"])


def _weights(options, transport, put):
    for actors in (1, 4) if options.quick else (1, 4, 16):
        with _wire.stage(options, NAME) as stage:
            config = _wire.config_file(stage, "--task", options.tasks[0])
            arguments = ["--actors", actors, "--rounds", 5 if options.quick else 50]
            times = _wire.result(_wire.swarm(stage, "weights", config, transport, *arguments))
        case = f"{transport}, weights to {actors}"
        put(case, "median", "ms", statistics.median(times["milliseconds"]))
        put(case, "worst", "ms", max(times["milliseconds"]))


def _cost_line(case, of):
    text = [case, f"{of['actor']:.3f}", f"{of['learner']:.3f}"]
    text.append(f"{of['play']:.1f}" if "play" in of else "")
    text.append(f"{100 * of['share']:.2f} %" if "share" in of else "")
    return text + [f"{of['episodes']:.0f}" if "episodes" in of else ""]


def table(rows):
    all_ = _stats.medians(rows)
    costs = [_cost_line(case, of) for case, of in all_.items() if "actor" in of]
    weights = [[case, f"{of['median']:.2f}", f"{of['worst']:.2f}"] for case, of in all_.items() if "worst" in of]
    return "\n\n".join([
        "Milliseconds of processor time for one episode of 500 steps (92 KB), all threads of a process;"
        " the share is that of the actor's processor time which is not spent playing:",
        _stats.markdown(["", "actor sends", "learner takes", "playing it", "share", "episodes/s"], costs),
        "Milliseconds from Publish until the last actor process has the snapshot (medians and worst of 50):",
        _stats.markdown(["", "median", "worst"], weights),
    ])
