"""An actor's needs: memory by envs, and time until it plays and has played."""

import time

from suite import _stats, _wire

NAME = "footprint"
HELP = "memory of a real actor process and of each further env; time from its start to the first episode"
ENVS = (1, 2, 4, 8)


def measure(options, record):
    for number in range(1, options.rounds + 1):
        def put(case, quantity, unit, value):
            record(case=case, quantity=quantity, unit=unit, round=number, value=value,
                   engine=options.engine)

        for task in options.tasks[:1] if options.quick else options.tasks:
            for envs in ENVS[:2] if options.quick else ENVS:
                _memory(options, task, envs, put)
            _start(options, task, put)


def _actor(stage, envs):
    return stage.start(stage.bin / "metronome-actor", "run", "--run", "swarm",
                       "--domain", stage.domain, "--envs", envs)


def _memory(options, task, envs, put):
    """After three batches in which every env has played."""
    settings = ["--task", task, "--steps", 4 * envs * 500, "--set", f"collection.episodes_per_update={envs}",
                "--set", "ppo.epochs=1", "--set", "ppo.minibatch=500"]
    with _wire.stage(options, NAME) as stage:
        learner = _wire.learner(stage, "udp", *settings)
        actor = _actor(stage, envs)
        learner.expect_update(3)
        put(task, f"{envs} envs", "MB RSS", _wire.megabytes(actor, "VmRSS"))
        assert learner.wait(_wire.PATIENCE) == 0, learner


def _start(options, task, put):
    """A learner waits already. Ready: the actor has loaded its scene, played the canonical episode
    and joined; first episode: the learner has it and has learnt from it."""
    settings = ["--task", task, "--steps", 500, "--set", "collection.episodes_per_update=1",
                "--set", "ppo.epochs=1", "--set", "ppo.minibatch=500"]
    with _wire.stage(options, NAME) as stage:
        learner = _wire.learner(stage, "udp", *settings)
        learner.expect_event("started")
        begin = time.monotonic()
        actor = _actor(stage, 1)
        actor.expect_text("joined run")
        put(task, "ready", "s", time.monotonic() - begin)
        learner.expect_update(1)
        whole = time.monotonic() - begin
        assert learner.wait(_wire.PATIENCE) == 0, learner
        put(task, "first episode", "s", whole - _wire.progress(stage)[0]["wall_update_seconds"])


def _line(task, of):
    sizes = {int(name.split()[0]): value for name, value in of.items() if name.endswith(" envs")}
    least, most = min(sizes), max(sizes)
    each = (sizes[most] - sizes[least]) / (most - least)
    figures = [f"{sizes[least]:.1f}", f"{each:.1f}", f"{most} envs: {sizes[most]:.1f}"]
    return [task, *figures, f"{of['ready']:.2f}", f"{of['first episode']:.2f}"]


def table(rows):
    lines = [_line(task, of) for task, of in _stats.medians(rows).items()]
    head = ["task", "actor of 1 env", "each further env", "most measured", "ready", "first episode"]
    return ("Resident memory of an actor process in MB, and seconds from its start until it can play and"
            " until the learner has its first episode:\n\n" + _stats.markdown(head, lines))
