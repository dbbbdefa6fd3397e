"""Whole training, end to end: ours, PyTorch PPO on EnvPool, Stable-Baselines3, and the bare engine.

All learn with the same network, batch, minibatch and ten epochs; the first update of each is
warm-up and not timed. Resets are included.
"""

import statistics

from suite import _stats, _train, loops, peers

NAME = "training"
HELP = "training steps a second end to end, against peers and two threads of the bare engine"
EACH_ENGINE = True

OURS, BARE, TORCH, SB3 = "Metronome", "bare x2", "PyTorch on EnvPool", "Stable-Baselines3"
# Plain PPO, as the peers have it.
SETTINGS = [
    "collection.episodes_per_update=16", "environment.reward=official", "policy.critic_time=false",
    "policy.initial_log_std=-0.5", "policy.noise_correlation=0", "ppo.entropy_coefficient=0.005", "ppo.kl_stop=0",
    "ppo.log_std_rate=1", "ppo.min_std=0", "ppo.minibatch=1000", "ppo.reward_scale_decay=1", "ppo.shared_heads=false",
    "ppo.std_decay=0",
]
USES = ["physics", "reset", "policy", "rollout", "wire", "check", "update", "save", "set-up"]


def measure(options, record):
    peers.ensure_installed(options.root)
    updates = 2 if options.quick else 13
    for round_number in range(1, options.rounds + 1):
        for task in options.tasks:
            def note(quantity, value, unit="steps/s", engine=None):
                record(case=task, quantity=quantity, unit=unit, round=round_number, value=value, engine=engine)

            note(BARE, loops.rates(options.build, task, options.quick, "bare")["bare x2"])
            settings = [word for setting in SETTINGS for word in ("--set", setting)]
            rows, uses = _train.run(options, task, steps=8000 * updates, arguments=settings)
            note(OURS, _train.steady_rate(rows))
            for use in USES:
                note(f"CPU {use}", uses.get(use, 0), "s")
            torch = peers.torch_ppo(options.root, task, updates=1 if options.quick else 5)
            note(TORCH, torch["steps_per_second"], engine=peers.ENVPOOL_ENGINE)
            sb3 = peers.sb3_ppo(options.root, task, steps=16000)
            note(SB3, sb3["steps_per_second"], engine=peers.OFFICIAL_ENGINE)


def rate_table(cases):
    columns = [BARE, OURS, TORCH, SB3]
    lines, ratios = [], []
    for case, of in cases.items():
        ratio = [_stats.median_ratio(of[OURS], of[other]) for other in (BARE, TORCH, SB3)]
        ratios.append(ratio)
        lines.append([case, *(f"{_stats.median(of[name]):.0f}" for name in columns), *(f"{r:.2f}" for r in ratio)])
    means = [f"{statistics.mean(column):.2f}" for column in zip(*ratios)]
    lines.append(["mean", *[""] * len(columns), *means])
    return _stats.markdown(["task", *columns, *(f"ours / {name}" for name in (BARE, "PyTorch", "SB3"))], lines)


def use_table(cases):
    """Shares of the CPU time that learner and actors take, start-up apart."""
    uses = [use for use in USES if use != "set-up"]
    lines = []
    for case, of in cases.items():
        seconds = {use: _stats.median(of[f"CPU {use}"]) for use in uses}
        total = sum(seconds.values())
        lines.append([case, *(f"{100 * seconds[use] / total:.1f} %" for use in uses)])
    return _stats.markdown(["share of CPU time", *uses], lines)


def table(rows):
    cases = _stats.by_case(rows)
    return rate_table(cases) + "\n\n" + use_table(cases)
