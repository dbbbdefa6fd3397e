"""A run goes on from its newest whole checkpoint, to the weights of an undisturbed run."""

import csv
import os

import pytest

from harness import ACTOR, BUILD, LEARNER, LONG, LONG_UPDATES, ROOT

USAGE = 2  # exit code


@pytest.fixture(scope="module")
def undisturbed(module_stage):
    """weights_sha256 and progress.csv without its wall-clock columns."""
    return module_stage.train("calm", small=LONG), progress(module_stage, "calm")


def progress(stage, run):
    with open(stage.runs / run / "progress.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return [{n: v for n, v in row.items() if n != "fps" and not n.startswith("wall_")} for row in rows]


def cut_down(stage):
    """A run whose learner was killed after some updates. @return its actor, which waits.

    Killed between a checkpoint's last byte and its becoming `latest`, a learner leaves one that counts as
    newer than the run; these tests are of the others.
    """
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(4)
    learner.kill()
    latest = stage.latest("run").resolve()
    for path in checkpoints(stage):
        if path > latest:
            path.unlink()
    return actor


def checkpoints(stage):
    """Paths, newest first."""
    return sorted((stage.runs / "run" / "checkpoints").glob("*.ckpt"), reverse=True)


def flip_a_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def goes_on_to_the_end(stage, actor, undisturbed):
    learner = stage.learner("run", "--resume", small=LONG)
    assert stage.finish("run", learner, [actor], LONG_UPDATES) == undisturbed[0]
    assert progress(stage, "run") == undisturbed[1]
    return learner


@pytest.mark.slow
def test_damaged_checkpoints_are_passed_over_and_put_aside(stage, undisturbed):
    actor = cut_down(stage)
    newest, before, good = checkpoints(stage)[:3]
    flip_a_bit(newest)
    before.write_bytes(b"")
    learner = goes_on_to_the_end(stage, actor, undisturbed)
    for word in (f"{newest}: damaged", f"{before}: ", f"GOING ON FROM {good}"):
        assert word in learner.text, learner
    assert newest.with_name(newest.name + ".damaged").exists()


@pytest.mark.slow
def test_a_lost_configuration_and_a_lost_newest_checkpoint_cost_nothing(stage, undisturbed):
    actor = cut_down(stage)
    config = stage.runs / "run" / "config.textproto"
    whole = config.read_text()
    config.write_text(whole[: len(whole) // 2])
    stage.latest("run").resolve().unlink()
    learner = goes_on_to_the_end(stage, actor, undisturbed)
    assert "is not whole: it is made anew from" in learner.text, learner
    assert config.read_text() == whole


def test_without_a_whole_checkpoint_it_names_each_and_the_way_out(stage):
    cut_down(stage).kill()
    damaged = checkpoints(stage)
    for path in damaged:
        path.write_bytes(b"torn")
    learner = stage.learner("run", "--resume", small=LONG)
    assert learner.wait(60) == USAGE, learner
    for word in (*map(str, damaged), "another --run"):
        assert word in learner.text, learner
    assert checkpoints(stage) == damaged, "nothing was moved"


@pytest.mark.slow
def test_services_and_people_are_told_and_go_on(stage, monkeypatch):
    """deploy/learner where the configuration is lost, deploy/train where a checkpoint is."""
    cut_down(stage).kill()
    (stage.runs / "run" / "config.textproto").unlink()
    monkeypatch.setenv("METRONOME_BIN", str(BUILD / "bin"))
    options = ("--domain", stage.domain, "--progress", "json")
    service = stage.start(ROOT / "deploy" / "learner", stage.runs, "run", *options, *LONG)
    assert service.expect_event("started")["update"] >= 3
    service.kill()
    checkpoints(stage)[0].write_bytes(b"torn")
    people = stage.start(ROOT / "deploy" / "train", *LONG[1:], "--run", "run", "--resume", "--build", BUILD,
                         "--runs", stage.runs, "--domain", stage.domain, "--actors", 1)
    assert people.wait() == 0, people
    assert "GOING ON FROM" in people.text, people


def test_reading_a_latest_that_leads_nowhere_names_the_others(stage):
    cut_down(stage).kill()
    newest, before = checkpoints(stage)[:2]
    newest.unlink()
    for command in ((LEARNER, "inspect"), (ACTOR, "evaluate", "--checkpoint")):
        reader = stage.start(*command, stage.latest("run"))
        assert reader.wait(60) == 1, reader
        assert newest.name in reader.text and f"there are {before.name}" in reader.text, reader


@pytest.mark.slow
def test_a_folder_of_runs_whose_name_is_no_text_serves_all_the_same(stage):
    runs = stage.runs.parent / os.fsdecode(b"runs \xff")
    words = ("--runs", runs, "--domain", stage.domain, "--progress", "none")
    learner = stage.start(LEARNER, "run", "--run", "run", *words, *LONG)
    actor = stage.actor("run")
    assert learner.wait() == 0, learner
    assert actor.wait() == 0, actor
    latest = runs / "run" / "checkpoints" / "latest"
    assert stage.inspect(latest)["version"] == LONG_UPDATES
    begun = stage.start(LEARNER, "run", "--run", "next", "--from", latest, *words, *LONG)
    begun.expect_text("waiting for actors")
    begun_with = stage.inspect(runs / "next" / "checkpoints" / "latest")["initial_weights"]
    assert begun_with.endswith("/run/checkpoints/latest"), begun_with
    begun.kill()
