"""Whole training by SAC, end to end: ours and Stable-Baselines3 on the official package.

Both make the same number of gradient samples for each step, with the same batch and widths. First
steps, which are at random, are not timed. Resets are included.
"""

from suite import _stats, _train, peers

NAME = "sac_training"
HELP = "training steps a second of SAC end to end, against Stable-Baselines3"
EACH_ENGINE = True

OURS, SB3 = "Metronome", "Stable-Baselines3"
BATCH, REPLAY_RATIO, HIDDEN, CRITIC_HIDDEN = 256, 8, [128, 128], [128, 128]
# The ratio is an outcome too: gradient steps are whole ones.
SAMPLES = "gradient samples a step of "


def ours(options, task, steps):
    """(steps a second, gradient samples a step) once learning has begun."""
    settings = {
        "sac.batch": BATCH, "sac.replay_ratio": REPLAY_RATIO, "policy.hidden": ",".join(map(str, HIDDEN)),
        "sac.critic_hidden": ",".join(map(str, CRITIC_HIDDEN))}
    words = [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    rows, _ = _train.run(options, task, steps=steps, arguments=["--algorithm", "sac", *words])
    rows = [row for row in rows if float(row["gradient_steps"]) > 0]
    samples = BATCH * sum(float(row["gradient_steps"]) for row in rows[1:])
    return _train.steady_rate(rows), samples / (int(rows[-1]["steps"]) - int(rows[0]["steps"]))


def measure(options, record):
    peers.ensure_installed(options.root)
    for round_number in range(1, options.rounds + 1):
        for task in options.tasks:
            def note(quantity, value, unit="steps/s", engine=None):
                record(case=task, quantity=quantity, unit=unit, round=round_number, value=value, engine=engine)

            rate, samples = ours(options, task, steps=14000 if options.quick else 40000)
            note(OURS, rate)
            note(SAMPLES + OURS, samples, "samples")
            sb3 = peers.sb3_sac(
                options.root, task, steps=1024 if options.quick else 8000, batch=BATCH, replay_ratio=REPLAY_RATIO,
                hidden=HIDDEN, critic_hidden=CRITIC_HIDDEN)
            note(SB3, sb3["steps_per_second"], engine=peers.OFFICIAL_ENGINE)
            note(SAMPLES + SB3, sb3["gradient_samples_per_step"], "samples", engine=peers.OFFICIAL_ENGINE)


def table(rows):
    lines = []
    for case, of in _stats.by_case(rows).items():
        lines.append([
            case, f"{_stats.median(of[OURS]):.0f}", f"{_stats.median(of[SB3]):.0f}",
            f"{_stats.median_ratio(of[OURS], of[SB3]):.2f}",
            f"{_stats.median(of[SAMPLES + OURS]):.2f}", f"{_stats.median(of[SAMPLES + SB3]):.2f}"])
    return _stats.markdown(["task", OURS, SB3, "ours / SB3", "our samples a step", "SB3's"], lines)
