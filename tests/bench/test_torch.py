"""Our SAC update against PyTorch's, on the same replay, samples and noise (peers/torch_sac.py)."""

import json
import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("METRONOME_BUILD", ROOT / "build"))
PYTHON = ROOT / ".cache/bench-peers/bin/python"

# Relative to the norm of a tensor, after 20 gradient steps: ours in float32, PyTorch's in float64.
MOST = 1e-5
# So far at least do the steps move a tensor: far beyond what is let pass.
LEAST_MOVED = 100 * MOST

# With the shipped 1e-8 Adam's first step is the gradient's sign, whatever its size: a weight whose gradient is
# 1e-10, the rest of a sum of terms a million times as large, moves another way in float32 than in float64. One
# such weight of 11264 puts its tensor 1.4e-5 away. Half of all gradients are above 5e-4.
EPSILON = ["--set", "sac.adam_epsilon=1e-4"]
SMALL = ["--set", "sac.batch=60", "--set", "sac.critic_hidden=64,48", "--set", "policy.hidden=40,24"]

ARMS = {
    "as shipped": [],
    "n_step 1": ["--set", "sac.n_step=1"],
    "values at the time limit": ["--set", "sac.time_limit_value=bootstrap"],
    "heads that share nothing": ["--set", "sac.shared_heads=false"],
    "heads that fade fast": ["--set", "sac.shared_heads_decay=100"],
    "critics with one head": ["--set", "policy.critic_heads=shared"],
    "critics that see no time": ["--set", "policy.critic_time=false"],
    "critics that are not normalised": ["--set", "sac.critic_norm=false"],
    # 10 gradient steps are the whole run.
    "a wanted entropy that falls": ["--set", "sac.random_episodes=1", "--set", "sac.replay_ratio=1", "--set", "total_steps=1100",
                                    "--set", "sac.target_std=0.1", "--set", "sac.final_target_std=1e-4",
                                    "--set", "sac.learning_rate_floor=1"],
    # 40 are: the tenth has the floor.
    "learning rates that fall": ["--set", "sac.random_episodes=1", "--set", "sac.replay_ratio=1", "--set", "total_steps=2900",
                                 "--set", "sac.learning_rate_floor=0.75"],
    "one head": ["--set", "policy.method=single"],
    "one head that sees the time": ["--set", "policy.method=single-time"],
    "three tasks": ["--tasks", "3"],
    "three tasks with heads of their own": ["--tasks", "3", "--set", "policy.heads_by=task-time", "--set", "policy.heads=3"],
    "clipped gradients and observations": ["--set", "sac.max_gradient_norm=0.1", "--set", "policy.observation_clip=1"],
}


@pytest.fixture(scope="module")
def distances(tmp_path_factory):
    """{arm: what torch_sac_steps.py says}"""
    if not (PYTHON.parents[1] / ".stamp").exists():
        pytest.skip("no PyTorch: tests/bench/peers/setup installs it")
    folders = [tmp_path_factory.mktemp("steps") for _ in ARMS]
    for folder, words in zip(folders, ARMS.values()):
        settings = [*EPSILON, *(words and SMALL), *words]
        subprocess.run([BUILD / "bin/sac_steps", "--out", folder, *settings], check=True, capture_output=True, timeout=60)
    command = [PYTHON, "-B", ROOT / "tests/bench/peers/torch_sac_steps.py", *folders]
    output = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300).stdout
    return dict(zip(ARMS, map(json.loads, output.splitlines())))


@pytest.mark.slow
@pytest.mark.parametrize("arm", ARMS)
def test_twenty_gradient_steps_of_sac_are_those_of_pytorch(distances, arm):
    tensors, closest = distances[arm]["tensors"], distances[arm]["closest"]
    tie = f"the critics' values came {closest:.0e} close: if that is below 1e-6, give the arm another seed"
    assert {name: distance for name, (distance, _) in tensors.items() if not distance <= MOST} == {}, tie
    assert {name: moved for name, (_, moved) in tensors.items() if not moved >= LEAST_MOVED} == {}
