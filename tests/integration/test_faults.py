"""Faults of practice: missing, second, returning and interrupted processes."""

import signal

import pytest

from harness import ENDLESS, LONG, LONG_UPDATES

FAILURE, NO_LEARNER, RIVAL = 1, 3, 4  # exit codes


@pytest.mark.slow
def test_an_actor_without_a_learner_says_so_and_gives_up(stage):
    actor = stage.actor("nobody", "--wait", "3")
    actor.expect_text("nobody", seconds=30)
    assert actor.wait(60) == NO_LEARNER, actor


def test_a_second_learner_of_a_run_is_refused(stage):
    first = stage.learner("run")
    first.expect_event("started")
    second = stage.learner("run", "--resume")
    assert second.wait() == RIVAL, second
    assert "learner" in second.text.lower(), second
    assert first.child.poll() is None, first


@pytest.mark.slow
def test_a_second_learner_on_another_machine_is_refused(stage, tmp_path):
    first = stage.learner("run")
    first.expect_event("started")
    # Another folder of runs is what another machine has: no lock is shared.
    second = stage.learner("run", runs=tmp_path / "elsewhere")
    assert second.wait() == RIVAL, second
    assert first.child.poll() is None, first
    assert stage.finish("run", first, [stage.actor("run")])


@pytest.mark.slow
def test_an_interrupted_learner_leaves_a_checkpoint_and_goes_on(stage):
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(2)
    learner.signal(signal.SIGINT)
    assert learner.wait() == 130, learner
    assert stage.inspect(stage.latest("run"))["version"] >= 2
    stage.finish("run", stage.learner("run", "--resume", small=LONG), [actor], LONG_UPDATES)


def test_an_interrupted_learner_that_cannot_leave_a_checkpoint_ends_with_1(stage):
    learner, actor = stage.learner("run", small=ENDLESS), stage.actor("run")
    learner.expect_update(1)
    # As a full disk does to the folder, without filling one: no file can be made in it.
    folder, aside = stage.runs / "run" / "checkpoints", stage.runs / "run" / "aside"
    folder.rename(aside)
    folder.touch()
    learner.expect_text("NOT WRITTEN")
    learner.signal(signal.SIGINT)
    assert learner.wait() == FAILURE, learner
    assert '"interrupted"' not in learner.text
    assert "is kept" in learner.text
    actor.kill()


def test_a_terminated_actor_ends_within_seconds(stage):
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(1)
    actor.signal(signal.SIGTERM)
    actor.wait(10)


@pytest.mark.slow
def test_an_actor_that_stays_serves_the_next_run_of_that_name(stage):
    actor = stage.actor("run", "--stay")
    learner = stage.learner("run")
    assert learner.wait() == 0, learner
    assert actor.child.poll() is None, actor
    more = stage.learner("run", "--resume")
    assert more.wait() == 0, more
    actor.signal(signal.SIGTERM)
    actor.wait(10)


@pytest.mark.slow
def test_an_actor_of_another_domain_is_not_seen(stage):
    learner = stage.learner("run")
    learner.expect_event("started")
    actor = stage.start(
        stage.actor("run").command[0],
        "run",
        "--run",
        "run",
        "--wait",
        "3",
        "--domain",
        (stage.domain + 1) % 101,
    )
    assert actor.wait(60) == NO_LEARNER, actor


def test_training_goes_on_while_checkpoints_cannot_be_written(stage):
    learner, actor = stage.learner("run"), stage.actor("run")
    learner.expect_update(2)
    # As a full disk does to the folder, without filling one: no file can be made in it.
    folder, aside = stage.runs / "run" / "checkpoints", stage.runs / "run" / "aside"
    folder.rename(aside)
    folder.touch()
    failed = learner.expect_text("checkpoint")
    assert "error" in failed.lower(), learner
    version = learner.expect_update(2)["update"]
    learner.expect_update(version + 1)
    folder.unlink()
    aside.rename(folder)
    assert stage.finish("run", learner, [actor])
