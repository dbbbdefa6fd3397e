"""How much one learner takes in from ever more simulated actors, and whether its memory grows."""

import statistics

from suite import _stats, _wire

NAME = "growth"
HELP = "a real learner's intake from 1 to 256 simulated actors, and its memory over many updates"
# (actor processes, envs each): real processes up to 64, then one that announces many envs.
SWARMS = ((1, 1), (2, 1), (4, 1), (16, 1), (64, 1), (1, 64), (1, 256))
SHARES = ("0.05", "1")


def measure(options, record):
    for number in range(1, options.rounds + 1):
        def put(case, quantity, unit, value):
            record(case=case, quantity=quantity, unit=unit, round=number, value=value,
                   engine=options.engine)

        for processes, envs in SWARMS[:2] if options.quick else SWARMS:
            for share in SHARES:
                _intake(options, "udp", processes, envs, share, put)
        _intake(options, "shm", 2, 1, SHARES[0], put)
        _memory(options, put)


def _settings(options, episodes, updates, share):
    return [
        "--task", options.tasks[0], "--steps", episodes * updates * 500,
        "--set", f"collection.episodes_per_update={episodes}",
        "--set", f"collection.check_share={share}",
        "--set", "ppo.epochs=1", "--set", f"ppo.minibatch={min(episodes, 128) * 500}",
    ]


def _intake(options, transport, processes, envs, share, put):
    """One huge batch under version 0, whose episodes are ready before the learner starts."""
    episodes = 128 if options.quick else 2048
    settings = _settings(options, episodes, 1, share)
    with _wire.stage(options, NAME) as stage:
        config = _wire.config_file(stage, *settings)
        actors = _wire.swarm(stage, "actors", config, transport, "--actors", processes,
                             "--envs", envs, "--prepared", episodes)
        actors.expect_text("ready", _wire.PATIENCE)
        learner = _wire.learner(stage, transport, *settings)
        assert learner.wait(_wire.PATIENCE) == 0, learner
        cpu = _wire.result(actors)["cpu_seconds"]
        row = _wire.progress(stage)[0]
    case = f"{transport}, {processes} x {envs}, check {share}"
    seconds = row["wall_collect_seconds"]
    put(case, "intake", "MB/s", row["wall_bytes_received"] / 1e6 / seconds)
    put(case, "episodes", "1/s", episodes / seconds)
    put(case, "repeated", "assignments", row["wall_episodes_reassigned"])
    put(case, "CPU", "ms of the actors' an episode", 1e3 * cpu / episodes)


def _memory(options, put):
    """Many small updates; the swarm works out each version's actions as it goes."""
    episodes, updates = (4, 8) if options.quick else (16, 300)
    settings = _settings(options, episodes, updates, SHARES[0])
    with _wire.stage(options, NAME) as stage:
        config = _wire.config_file(stage, *settings)
        actors = _wire.swarm(stage, "actors", config, "udp", "--actors", 2, "--prepared", 0)
        actors.expect_text("ready", _wire.PATIENCE)
        learner = _wire.learner(stage, "udp", *settings)
        resident = []
        for update in range(1, updates):
            learner.expect_update(update)
            resident.append(_wire.megabytes(learner, "VmRSS"))
        high = _wire.megabytes(learner, "VmHWM")
        assert learner.wait(_wire.PATIENCE) == 0, learner
    resident = [value for value in resident if value]
    quarter = max(1, len(resident) // 4)
    case = f"memory over {updates} updates of {episodes} episodes"
    put(case, "second quarter", "MB RSS", statistics.median(resident[quarter : 2 * quarter] or resident))
    put(case, "last quarter", "MB RSS", statistics.median(resident[-quarter:]))
    put(case, "highest", "MB HWM", high or max(resident))


def _intake_line(case, of):
    figures = [of["intake"], of["episodes"], of["repeated"]]
    return [case, *(f"{value:.0f}" for value in figures), f"{of['CPU']:.2f}"]


def table(rows):
    all_ = _stats.medians(rows)
    intake = [_intake_line(case, of) for case, of in all_.items() if "intake" in of]
    memory = [[case, *(f"{of[name]:.1f}" for name in ("second quarter", "last quarter", "highest"))]
              for case, of in all_.items() if "highest" in of]
    return "\n\n".join([
        "Intake of one learner, from its first assignment to the last episode of a batch of 2048 (92 KB each)."
        " Simulated actors share the machine's cores with it; `processes x envs`, and the share of steps"
        " that the learner recomputes:",
        _stats.markdown(["", "MB/s", "episodes/s", "assignments repeated", "actors' CPU, ms an episode"], intake),
        "Memory of the learner, MB (medians of the second and the last quarter of the updates):",
        _stats.markdown(["", "second quarter", "last quarter", "highest"], memory),
    ])
