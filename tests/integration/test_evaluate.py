"""Evaluating and drawing on the run's own terms, and being told where the terms are others."""

import csv
import json
import os
import signal
import subprocess
import time

import pytest

from harness import ACTOR, HORIZON

SEED = 7  # of the runs, see harness.SMALL
ENDLESS = ("--episodes", "1000000")


@pytest.fixture(scope="module")
def fixed(module_stage):
    """The checkpoint of a run that was trained on one placement."""
    module_stage.train("fixed", "--placements", "fixed")
    return module_stage.latest("fixed")


def run(*command, status=0, environment=None):
    done = subprocess.run(
        [ACTOR, *map(str, command)],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env=os.environ | (environment or {}),
    )
    assert done.returncode == status, done
    return done


def evaluate(checkpoint, *options):
    """@return (its JSON, what it warned of)."""
    done = run("evaluate", "--checkpoint", checkpoint, "--json", *options)
    return json.loads(done.stdout), done.stderr.splitlines()


def draw(checkpoint, folder, *options):
    """@return (return of the episode, rows of the path, what it warned of)."""
    table = folder / "path.csv"
    done = run("render", "--checkpoint", checkpoint, "--csv", table, *options)
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return float(done.stdout.split("return ")[1].split(",")[0]), rows, done.stderr.splitlines()


def placement(task, mode, seed):
    done = run("placements", "--task", task, "--mode", mode, "--seed", seed, "--count", 1)
    (row,) = csv.DictReader(done.stdout.splitlines())
    return {name: float(value) for name, value in row.items()}


def test_a_run_on_one_placement_is_evaluated_on_it_once_and_without_a_warning(fixed):
    report, warnings = evaluate(fixed, "--placements", "fixed")
    assert warnings == report["differences"] == []
    assert (report["placements"], report["episodes"]) == ("fixed", 1)
    assert (report["horizon"], report["goal_visible"]) == (HORIZON, True)
    assert evaluate(fixed, "--placements", "fixed", "--seed", "99") == (report, [])


def test_more_episodes_of_one_placement_are_said_to_be_the_same(fixed):
    once, _ = evaluate(fixed, "--placements", "fixed")
    report, warnings = evaluate(fixed, "--placements", "fixed", "--episodes", "400")
    assert report["episodes"] == 400
    assert report["return"] == pytest.approx(once["return"], rel=1e-12)
    assert [line for line in warnings if "the same again" in line], warnings


def test_what_is_drawn_is_the_runs_own_placement(fixed, tmp_path):
    played, rows, warnings = draw(fixed, tmp_path, "--placements", "fixed")
    own = placement("push", "fixed", SEED)
    assert warnings == []
    assert float(rows[0]["object_x"]) == pytest.approx(own["obj_x"], abs=1e-3)
    assert float(rows[0]["object_y"]) == pytest.approx(own["obj_y"], abs=1e-3)
    assert played == evaluate(fixed, "--placements", "fixed")[0]["return"]  # to the bit


def test_other_placements_than_in_training_are_a_warning_with_the_way_back(fixed, tmp_path):
    report, warnings = evaluate(fixed, "--episodes", "2")
    _, _, drawn = draw(fixed, tmp_path)
    (difference,) = report["differences"]
    assert warnings == drawn == [f"warning: {difference}"]
    assert "placements fixed" in difference
    assert "--placements fixed" in difference
    text = run("evaluate", "--checkpoint", fixed, "--episodes", "2").stdout
    assert "2 episodes of 50 steps, placements random, goal visible" in text


def test_another_task_is_a_warning_and_has_the_placement_of_a_run_of_that_seed(fixed, tmp_path):
    options = ("--placements", "fixed", "--task", "assembly")
    report, warnings = evaluate(fixed, *options)
    assert warnings == [f"warning: {difference}" for difference in report["differences"]]
    assert ["task push" in line and "task assembly" in line for line in warnings] == [True]
    played, rows, _ = draw(fixed, tmp_path, *options)
    own = placement("assembly", "fixed", SEED)
    assert float(rows[0]["object_y"]) == pytest.approx(own["obj_y"], abs=0.05)
    assert played == report["return"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_evaluation_ends_at_once_and_says_nothing(stage, fixed, number):
    evaluation = stage.start(ACTOR, "evaluate", "--checkpoint", fixed, *ENDLESS)
    evaluation.expect_text("placements random")  # the warning comes before the first episode
    evaluation.signal(number)
    assert evaluation.wait(30) == 128 + number, evaluation
    assert [line for line in evaluation.lines if not line.startswith("warning: ")] == []


FAKE_ENCODER = """#!/bin/sh
for output; do :; done
echo begun >"$output"
touch "$FOLDER/started"
cat >/dev/null
touch "$FOLDER/ended"
"""


def appears(path, seconds=60):
    deadline = time.monotonic() + seconds
    while not path.exists():
        assert time.monotonic() < deadline, f"{path} does not come"
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
@pytest.mark.slow
def test_a_stopped_render_leaves_no_file_and_no_encoder(fixed, tmp_path, number):
    encoder, videos = tmp_path / "bin" / "ffmpeg", tmp_path / "videos"
    encoder.parent.mkdir()
    encoder.write_text(FAKE_ENCODER, encoding="utf-8")
    encoder.chmod(0o755)
    videos.mkdir()
    variables = {"PATH": f"{encoder.parent}:{os.environ['PATH']}", "FOLDER": str(tmp_path)}
    command = (ACTOR, "render", "--checkpoint", fixed, "--out", videos / "video.mp4")
    render = subprocess.Popen([*map(str, command)], env=os.environ | variables)
    try:
        appears(tmp_path / "started")
        render.send_signal(number)
        render.wait(30)
    finally:
        render.kill()
    appears(tmp_path / "ended")
    assert list(videos.iterdir()) == []
    if number in (signal.SIGINT, signal.SIGTERM):
        assert render.returncode == 128 + number


# Obeys interrupts whatever it was started with, as ffmpeg does.
OBEDIENT_ENCODER = """#!/usr/bin/python3
import os, signal, sys
signal.signal(signal.SIGINT, lambda *_: sys.exit(1))
open(f"{os.environ['FOLDER']}/started", "w").close()
open(f"{os.environ['FOLDER']}/go").read()
sys.stdin.buffer.read()
with open(sys.argv[-1], "w") as file:
    file.write("a video")
"""


@pytest.mark.slow
def test_an_interrupt_that_was_ignored_at_the_start_ends_no_encoder(fixed, tmp_path):
    encoder, video = tmp_path / "bin" / "ffmpeg", tmp_path / "video.mp4"
    encoder.parent.mkdir()
    encoder.write_text(OBEDIENT_ENCODER, encoding="utf-8")
    encoder.chmod(0o755)
    os.mkfifo(tmp_path / "go")
    variables = {"PATH": f"{encoder.parent}:{os.environ['PATH']}", "FOLDER": str(tmp_path)}
    command = ("env", "--ignore-signal=INT", ACTOR, "render", "--checkpoint", fixed, "--out", video)
    render = subprocess.Popen([*map(str, command)], env=os.environ | variables, start_new_session=True)
    try:
        appears(tmp_path / "started")
        os.killpg(render.pid, signal.SIGINT)  # as a terminal's Ctrl-C does
        (tmp_path / "go").write_text("")
        assert render.wait(60) == 0
    finally:
        render.kill()
    assert video.read_text() == "a video"


def test_what_cannot_be_written_is_an_error(fixed, tmp_path):
    with open("/dev/full", "w", encoding="utf-8") as full:
        for command in (("evaluate", "--placements", "fixed"), ("render", "--csv", tmp_path / "path.csv")):
            words = [ACTOR, command[0], "--checkpoint", fixed, *command[1:]]
            done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=300)
            assert done.returncode == 1, done
            assert "standard output" in done.stderr
