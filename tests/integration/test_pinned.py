"""Twenty updates of a small network end with known weights: a change that is to leave every bit alone is seen to."""

import re
from pathlib import Path

import pytest

from harness import BUILD, small, updates_of

PINNED = Path(__file__).with_name("pinned.txt")
CACHE = (BUILD / "CMakeCache.txt").read_text()


def cached(name):
    return re.search(rf"^METRONOME_{name}:STRING=(.*)$", CACHE, re.M)[1]


def maker():
    return re.search(r"^vendor_id\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.M)[1]


def known():
    """{(engine, maker of the processor): weights_sha256}."""
    rows = [line.split() for line in PINNED.read_text().splitlines() if line and not line.startswith("#")]
    return {(engine, maker): sha for engine, maker, sha in rows}


@pytest.mark.skipif(cached("MARCH") != "x86-64-v3", reason="other instructions give other bits")
def test_twenty_updates_end_with_the_pinned_weights(stage):
    words = small(4000)
    assert updates_of(words) == 20
    # Minibatches of more than one shard, which are summed in their order.
    sha = stage.train("pinned", "--set", "policy.hidden=32,32", "--set", "ppo.minibatch=200", small=words)
    row = (cached("MUJOCO"), maker())
    if row not in known():
        pytest.skip(f"no weights are pinned for this processor's maker; it gives: {' '.join(row)} {sha}")
    assert sha == known()[row], f"if bits were to change, {PINNED.name} is to say: {' '.join(row)} {sha}"
