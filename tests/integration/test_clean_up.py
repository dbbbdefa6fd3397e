"""Left-overs of processes: nothing after an end, and what kills leave goes at the next start."""

import signal
from pathlib import Path

import pytest

from harness import LONG, LONG_UPDATES

MEMORY = Path("/dev/shm")
SHM = ("--transport", "shm")


def files():
    """The files of Fast DDS and Metronome in shared memory now."""
    return {f.name for f in MEMORY.iterdir() if "fastrtps_" in f.name or "metronome-" in f.name}


@pytest.mark.slow
def test_nothing_is_left_of_a_run_that_ends(stage):
    before = files()
    stage.train("run", *SHM, actors=2, actor_options=SHM)
    assert files() <= before


@pytest.mark.slow
def test_what_killed_processes_of_a_run_left_is_removed_when_the_run_goes_on(stage):
    before = files()
    learner, actor = stage.learner("run", *SHM, small=LONG), stage.actor("run", *SHM)
    learner.expect_update(2)
    learner.kill()
    actor.kill()
    left = files() - before
    assert any(name.startswith("fastrtps_port") for name in left)
    again, helper = stage.learner("run", "--resume", *SHM, small=LONG), stage.actor("run", *SHM)
    stage.finish("run", again, [helper], LONG_UPDATES)
    assert "of this run left" in again.text + helper.text
    assert files() <= before, files() - before


@pytest.mark.slow
def test_what_belongs_to_other_runs_stays(stage):
    before = files()
    # One that lives, of a run whose name begins alike, and one that was killed.
    alive, dead = stage.learner("run-1", *SHM), stage.learner("other", *SHM)
    alive.expect_event("started")
    dead.expect_event("started")
    dead.kill()
    theirs = files() - before
    stage.train("run", *SHM, actor_options=SHM)
    assert theirs <= files()
    again = stage.start(*dead.command, "--resume")
    again.expect_event("started")
    for learner in (alive, again):
        learner.signal(signal.SIGINT)
        learner.wait()
    assert files() <= before


@pytest.mark.slow
def test_a_note_cannot_be_used_to_remove_other_files(stage):
    victim = MEMORY / "metronome-test-victim"
    victim.touch()
    note = MEMORY / f"metronome-{stage.domain}-run-1-1"
    note.write_text(f"../shm/{victim.name}\n{victim.name}\nfastrtps_../{victim.name}\n")
    try:
        stage.train("run", *SHM, actor_options=SHM)
        assert victim.exists()
        assert not note.exists()
    finally:
        victim.unlink()
