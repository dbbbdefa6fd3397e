"""A limit on the size of files is a kind of full disk, whatever is written."""

import os
import resource
import subprocess

import pytest

from harness import ACTOR, LEARNER, LONG, LONG_UPDATES, ROOT

POLICY = ROOT / "results" / "policies" / "push.ckpt"


def limited(blocks, *command):
    """The command where no file grows beyond so many KiB; standard output goes to the file `$OUT`."""
    return ("bash", "-c", f'ulimit -f {blocks}; exec "$@" >"$OUT"', "-", *command)


@pytest.mark.slow
def test_training_goes_on_while_files_cannot_grow(stage):
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(2)
    before = resource.prlimit(learner.child.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(learner.child.pid, resource.RLIMIT_FSIZE, (1000, before[1]))
    learner.expect_text("NOT WRITTEN")
    learner.expect_update(learner.updates() + 2)
    resource.prlimit(learner.child.pid, resource.RLIMIT_FSIZE, before)
    assert stage.finish("run", learner, [actor], LONG_UPDATES)
    rows = (stage.runs / "run" / "progress.csv").read_text().splitlines()
    assert len(rows) == 1 + LONG_UPDATES, "rows waited for room"


def test_a_start_that_cannot_write_its_first_checkpoint_says_so(stage, tmp_path, monkeypatch):
    monkeypatch.setenv("OUT", str(tmp_path / "out"))
    words = ("--run", "run", "--runs", stage.runs, "--domain", stage.domain)
    learner = stage.start(*limited(8, LEARNER, "run", *words, *LONG))
    assert learner.wait() == 1, learner
    assert "000000.ckpt" in learner.text and "File too large" in learner.text, learner


@pytest.mark.slow
def test_an_actor_plays_on_when_its_log_is_full_or_nobody_reads_it(stage, tmp_path, monkeypatch):
    log = tmp_path / "log"
    monkeypatch.setenv("OUT", "/dev/null")
    words = (ACTOR, "run", "--run", "run", "--domain", stage.domain, "--log", "debug")
    full = stage.start("bash", "-c", f'ulimit -f 0; exec "$@" 2>"{log}"', "-", *words)
    read, write = os.pipe()
    unread = subprocess.Popen([str(word) for word in words], stderr=write)
    os.close(read)
    os.close(write)
    try:
        stage.finish("run", stage.learner("run", small=LONG), [full], LONG_UPDATES)
        assert unread.wait(60) == 0
    finally:
        unread.kill()


@pytest.mark.parametrize(
    "command",
    [
        (LEARNER, "inspect", POLICY),
        (LEARNER, "config", "--task", "push"),
        (ACTOR, "placements", "--task", "push", "--mode", "mt1", "--seed", "1"),
        (ACTOR, "evaluate", "--checkpoint", POLICY, "--episodes", "1"),
    ],
    ids=lambda command: command[1],
)
def test_a_result_that_cannot_be_written_is_an_error(stage, tmp_path, monkeypatch, command):
    for out in (str(tmp_path / "out"), "/dev/full"):
        monkeypatch.setenv("OUT", out)
        process = stage.start(*limited(0, *command))
        assert process.wait(60) == 1, process
        assert "cannot write" in process.text, process


@pytest.mark.slow
def test_a_video_that_is_larger_than_files_may_be_is_an_error(stage, tmp_path, monkeypatch):
    monkeypatch.setenv("OUT", "/dev/null")
    video = tmp_path / "video.mp4"
    video.write_text("an older one")
    render = stage.start(*limited(20, ACTOR, "render", "--checkpoint", POLICY, "--out", video, "--every", 5))
    assert render.wait() == 1, render
    assert str(video) in render.text and "ulimit -f" in render.text, render
    assert video.read_text() == "an older one"
