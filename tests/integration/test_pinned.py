"""Twenty updates of a small network end with known weights: a change that is to leave every bit alone is seen to."""

from pathlib import Path

from harness import ENGINE, small, updates_of

PINNED = Path(__file__).with_name("pinned.txt")


def known():
    """{engine: weights_sha256}."""
    return dict(line.split() for line in PINNED.read_text().splitlines() if not line.startswith("#"))


def test_twenty_updates_end_with_the_pinned_weights(stage):
    words = small(4000)
    assert updates_of(words) == 20
    # Minibatches of several samples a group.
    sha = stage.train("pinned", "--set", "policy.hidden=32,32", "--set", "ppo.minibatch=200", small=words)
    assert sha == known()[ENGINE], f"if bits were to change, {PINNED.name} is to say: {ENGINE} {sha}"
