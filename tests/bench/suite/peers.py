"""Speed of what one might use instead: EnvPool, the official package, PyTorch, Stable-Baselines3.

They live in a virtual environment of their own (tests/bench/peers). measure() and table() are this
section of the benchmark, stepping alone; other sections interleave the training programs with ours.
"""

import json
import subprocess
import sys

from suite import _stats

NAME = "peers"
HELP = "control steps a second of EnvPool and of the official Python package, random actions"

# MuJoCo inside: EnvPool 1.2.5 is built with its own, the official package pins one.
ENVPOOL_ENGINE, OFFICIAL_ENGINE = "3.6.0", "3.3.0"

# The measurements: quantity, engine, script and arguments. With these numbers of environments EnvPool
# was fastest (of 8, 16, 32 and 64, two threads).
STEPPING = [
    ("EnvPool sync x1", ENVPOOL_ENGINE, "envpool_steps", {"mode": "sync", "envs": 64, "threads": 1}),
    ("EnvPool async x1", ENVPOOL_ENGINE, "envpool_steps", {"mode": "async", "envs": 32, "threads": 1}),
    ("EnvPool sync x2", ENVPOOL_ENGINE, "envpool_steps", {"mode": "sync", "envs": 64, "threads": 2}),
    ("EnvPool async x2", ENVPOOL_ENGINE, "envpool_steps", {"mode": "async", "envs": 32, "threads": 2}),
    ("official x1", OFFICIAL_ENGINE, "official_steps", {}),
]


def ensure_installed(root):
    """Installs the peers if they are not there yet; that needs the network and takes minutes."""
    subprocess.run([root / "tests/bench/peers/setup"], check=True, stdout=sys.stderr)


def run(root, script, *words, **options):
    """The JSON object that a script of tests/bench/peers prints; ends the program if the script fails.

    run(root, "torch_ppo", task="push", env_threads=2) is `torch_ppo.py --task push --env-threads 2`;
    an option that is True is a flag, and one that is a list has several values.
    """
    command = [str(root / ".cache/bench-peers/bin/python"), "-W", "ignore"]
    command += [str(root / "tests/bench/peers" / f"{script}.py"), *map(str, words)]
    for name, value in options.items():
        command.append("--" + name.replace("_", "-"))
        if value is not True:
            command += map(str, value if isinstance(value, list) else [value])
    result = subprocess.run(command, capture_output=True, text=True, cwd=root)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)} failed with status {result.returncode}:\n{result.stdout}{result.stderr}")
    return json.loads(result.stdout.splitlines()[-1])


def torch_ppo(root, task, updates, **options):
    """PyTorch PPO on EnvPool, Metronome's network and batch: {"steps_per_second": ..., ...}."""
    return run(root, "torch_ppo", task=task, updates=updates, **options)


def sb3_ppo(root, task, steps, **options):
    """Stable-Baselines3 PPO on the official package, 8000 of `steps` untimed: as above."""
    return run(root, "sb3_ppo", task=task, steps=steps, **options)


def torch_update(root, width, minibatch, **options):
    """PyTorch's PPO update alone: {"samples_per_second": ..., "gemm_gflops": ..., "torch": ...}."""
    return run(root, "torch_update", width=width, minibatch=minibatch, **options)


def sb3_sac(root, task, steps, **options):
    """Stable-Baselines3 SAC on the official package: {"steps_per_second": ..., "gradient_samples_per_step": ..., ...}."""
    return run(root, "sb3_sac", task=task, steps=steps, **options)


def torch_sac_steps(root, folder, threads, **options):
    """PyTorch's SAC gradient step alone, of what sac_steps wrote: {"samples_per_second": ..., "torch": ...}."""
    return run(root, "torch_sac_steps", folder, threads=threads, **options)


def measure(options, record):
    ensure_installed(options.root)
    seconds = 1 if options.quick else 5
    for round_number in range(1, options.rounds + 1):
        for task in options.tasks:
            for quantity, engine, script, arguments in STEPPING:
                result = run(options.root, script, task=task, seconds=seconds, **arguments)
                record(case=task, quantity=quantity, unit="steps/s", round=round_number,
                       value=result["steps_per_second"], engine=engine)


def table(rows):
    """Markdown, one line a task: medians over the rounds."""
    columns = list(dict.fromkeys(row["quantity"] for row in rows))
    lines = [
        [case, *(f"{of[name]:.0f}" if name in of else "" for name in columns)]
        for case, of in _stats.medians(rows).items()
    ]
    return _stats.markdown(["task", *columns], lines)
