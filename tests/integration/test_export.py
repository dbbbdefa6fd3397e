"""A policy by itself plays as its checkpoint does, and no run goes on from it."""

import shutil

import pytest

from harness import ACTOR, LEARNER

USAGE = 2  # exit code
LARGEST = 200_000  # bytes


@pytest.fixture(scope="module")
def exported(module_stage, tmp_path_factory):
    """(stage, a run's last checkpoint, its policy by itself)."""
    module_stage.train("run")
    source = module_stage.latest("run").resolve()
    policy = tmp_path_factory.mktemp("policy") / "push.ckpt"
    export = module_stage.start(LEARNER, "export", source, "--out", policy)
    assert export.wait() == 0, export
    assert not export.text, export
    return module_stage, source, policy


def evaluated(stage, checkpoint):
    process = stage.start(ACTOR, "evaluate", "--checkpoint", checkpoint, "--episodes", 3, "--json")
    assert process.wait() == 0, process
    report = process.json()
    return {key: value for key, value in report.items() if key != "checkpoint"}


def test_it_plays_as_its_checkpoint_does(exported):
    stage, source, policy = exported
    assert evaluated(stage, policy) == evaluated(stage, source)


def test_it_says_which_run_it_is_of_and_is_small(exported):
    stage, source, policy = exported
    whole, alone = stage.inspect(source), stage.inspect(policy)
    assert alone["algorithm_format"] == 0
    gone = {"algorithm_format", "wall_seconds"}
    assert {key: alone[key] for key in alone.keys() - gone} == {key: whole[key] for key in whole.keys() - gone}
    # The actor's parameters alone; beside them the configuration and 39 means and scales.
    assert policy.stat().st_size < 4 * alone["actor_parameters"] + 2000 < LARGEST < source.stat().st_size


def test_a_policy_exported_again_has_the_same_bytes(exported, tmp_path):
    stage, _, policy = exported
    again = stage.start(LEARNER, "export", policy, "--out", tmp_path / "again.ckpt")
    assert again.wait() == 0, again
    assert (tmp_path / "again.ckpt").read_bytes() == policy.read_bytes()


def test_no_run_goes_on_from_it_or_begins_with_it(exported):
    stage, source, policy = exported
    last = source.read_bytes()
    shutil.copy(policy, source)
    resumed = stage.learner("run", "--resume")
    status = resumed.wait(60)
    source.write_bytes(last)
    assert status == USAGE, resumed
    assert f"{source}: it holds a policy by itself" in resumed.text, resumed
    begun = stage.learner("next", "--from", policy)
    assert begun.wait(60) == USAGE, begun
    assert f"{policy}: it holds a policy by itself" in begun.text, begun
    assert not (stage.runs / "next").exists()


@pytest.mark.parametrize("words, says", [
    ((), "name the CHECKPOINT"),
    (("a.ckpt",), "--out FILE"),
])
def test_what_is_missing_is_named(stage, words, says):
    export = stage.start(LEARNER, "export", *words)
    assert export.wait(30) == USAGE, export
    assert says in export.text, export


def test_a_damaged_checkpoint_leaves_no_file(stage, tmp_path):
    (tmp_path / "torn.ckpt").write_bytes(b"torn")
    export = stage.start(LEARNER, "export", tmp_path / "torn.ckpt", "--out", tmp_path / "policy.ckpt")
    assert export.wait(30) == 1, export
    assert "torn.ckpt" in export.text, export
    assert not (tmp_path / "policy.ckpt").exists()
