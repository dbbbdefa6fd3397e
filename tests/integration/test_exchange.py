"""Heads in each other's blocks of time: `evaluate --head-order`, and `deploy/exchange`, which tries them all."""

import csv
import shutil
import signal
import time
from pathlib import Path

import pytest

from harness import ACTOR, BUILD, DEADLINE, ROOT

EVALUATE = ("--episodes", 2, "--seed", 4711, "--json")


@pytest.fixture(scope="module")
def checkpoint(module_stage, tmp_path_factory):
    module_stage.train("two", "--heads", "2")
    return shutil.copy(module_stage.latest("two"), tmp_path_factory.mktemp("policies") / "two.ckpt")


def evaluate(stage, checkpoint, *options):
    done = stage.start(ACTOR, "evaluate", "--checkpoint", checkpoint, *EVALUATE, *options)
    assert done.wait() == 0, done
    return done.json()


def exchange(stage, checkpoint, out, *options):
    return stage.start(ROOT / "deploy" / "exchange", checkpoint, "--out", out, "--episodes", 2, "--seed", 4711,
                       "--build", BUILD, *options)


def rows(out):
    with open(out / "two.csv", newline="", encoding="utf-8") as file:
        return {row["order"]: row for row in csv.DictReader(file)}


def test_the_trained_order_asked_for_is_the_policy_as_it_is(stage, checkpoint):
    own = evaluate(stage, checkpoint)
    assert evaluate(stage, checkpoint, "--head-order", "0,1") == own | {"head_order": [0, 1]}
    assert evaluate(stage, checkpoint, "--head-order", "1,1")["return"] != own["return"]


@pytest.mark.parametrize("order, says", [
    ("0", "1 heads for the policy's 2 blocks of time"),
    ("0,2", "no head 2: the policy has 0 to 1"),
    ("0,-1", "--head-order"),
])
def test_an_order_that_the_policy_has_not_is_refused(stage, checkpoint, order, says):
    refused = stage.start(ACTOR, "evaluate", "--checkpoint", checkpoint, *EVALUATE, f"--head-order={order}")
    assert refused.wait() == 2, refused
    assert "--head-order" in refused.text and says in refused.text


@pytest.mark.slow
def test_every_exchange_is_evaluated_once(stage, checkpoint, tmp_path):
    first = exchange(stage, checkpoint, tmp_path)
    assert first.wait() == 0, first
    made = rows(tmp_path)
    assert list(made) == ["0,1", "1,1", "0,0"]
    for order, row in made.items():
        said = evaluate(stage, checkpoint, "--head-order", order)
        assert [float(row[name]) for name in ("success", "return")] == [said["success"], said["return"]]
    # Cut, as by an interruption: only what is missing is made again.
    lines = (tmp_path / "two.csv").read_text().splitlines(keepends=True)
    (tmp_path / "two.csv").write_text("".join(lines[:-1]))
    again = exchange(stage, checkpoint, tmp_path)
    assert again.wait() == 0, again
    assert rows(tmp_path) == made and again.text.count("success") == 1, again


@pytest.mark.slow
def test_rows_of_another_evaluation_are_not_mixed(stage, checkpoint, tmp_path):
    assert exchange(stage, checkpoint, tmp_path).wait() == 0
    before = (tmp_path / "two.csv").read_bytes()
    other = exchange(stage, checkpoint, tmp_path, "--seed", 1)
    assert other.wait() == 1, other
    assert "two.csv has rows of seed 4711, not 1" in other.text
    assert (tmp_path / "two.csv").read_bytes() == before


def commands_with(*words):
    """Command lines of processes that have all of these words."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = path.read_text(errors="replace").split("\0")
        except OSError:
            continue  # it has ended
        if set(words) <= set(command):
            found.append(command)
    return found


def wait_until(condition, process):
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline, process
        time.sleep(0.01)


def test_other_placements_than_in_training_are_said_and_a_stop_ends_the_evaluation_too(stage, tmp_path):
    stage.train("fixed", "--placements", "fixed", "--heads", "2")
    checkpoint = shutil.copy(stage.latest("fixed"), tmp_path / "fixed.ckpt")
    evaluation = ("evaluate", str(checkpoint), "1000000")
    exchanging = exchange(stage, checkpoint, tmp_path, "--episodes", 1000000)
    exchanging.expect_text("warning: fixed: trained with placements fixed")
    wait_until(lambda: commands_with(*evaluation), exchanging)
    exchanging.signal(signal.SIGTERM)
    assert exchanging.wait(30) == 128 + signal.SIGTERM, exchanging
    # Where the stop came before Python knew its child, the kernel ends the child after its parent.
    wait_until(lambda: not commands_with(*evaluation), exchanging)


def test_a_killed_exchange_leaves_no_evaluation(stage, checkpoint, tmp_path):
    exchanging = exchange(stage, checkpoint, tmp_path, "--episodes", 1000000)
    evaluation = ("evaluate", str(checkpoint), "1000000")
    wait_until(lambda: commands_with(*evaluation), exchanging)
    exchanging.kill()
    wait_until(lambda: not commands_with(*evaluation), exchanging)
