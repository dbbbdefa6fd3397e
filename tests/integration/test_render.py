"""Pictures and videos of a checkpoint's episodes, by the program as users call it."""

import csv
import json
import os
import struct
import subprocess

import pytest

from harness import ACTOR, HORIZON

HEADS = 10


@pytest.fixture(scope="module")
def checkpoint(module_stage):
    module_stage.train("whole")
    return module_stage.latest("whole")


def render(checkpoint, *options, **environment):
    """Runs the command to its end, without a display."""
    variables = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return subprocess.run(
        [ACTOR, "render", "--checkpoint", checkpoint, *options],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env=variables | environment,
    )


def refusal(status, checkpoint, *options, **environment):
    """The answer of `render` to a request that it cannot meet."""
    done = render(checkpoint, *options, **environment)
    assert done.returncode == status, done
    assert done.stdout == "", done
    return done.stderr


def played_return(done):
    assert done.returncode == 0, done
    return float(done.stdout.split("return ")[1].split(",")[0])


def evaluated_return(checkpoint, *options):
    done = subprocess.run(
        [ACTOR, "evaluate", "--checkpoint", checkpoint, "--json", *options],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return json.loads(done.stdout)["return"]


@pytest.mark.slow
def test_a_picture_has_the_size_asked_for_and_is_not_blank(checkpoint, tmp_path):
    picture = tmp_path / "picture.png"
    done = render(checkpoint, "--out", picture, "--size", "400x300")
    assert done.returncode == 0, done
    content = picture.read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", content[16:24]) == (400, 300)
    assert len(content) > 20_000  # a blank one is below 1000
    assert done.stdout.endswith(f"\nwrote {picture}\n"), done
    assert [file.name for file in tmp_path.iterdir()] == ["picture.png"]


@pytest.mark.parametrize("placements", ["random", "mt1"])
@pytest.mark.slow
def test_the_episode_drawn_is_the_one_that_evaluate_plays(checkpoint, tmp_path, placements):
    options = ("--seed", "5", "--placements", placements)
    picture = tmp_path / "picture.png"
    drawn = played_return(render(checkpoint, "--out", picture, "--size", "320x240", *options))
    assert drawn == evaluated_return(checkpoint, "--episodes", "1", *options)  # to the bit


def test_episodes_are_those_of_evaluate_in_order(checkpoint, tmp_path):
    table = tmp_path / "path.csv"
    returns = [
        played_return(render(checkpoint, "--csv", table, "--episode", str(number)))
        for number in range(3)
    ]
    assert len(set(returns)) == 3
    assert sum(returns) / 3 == pytest.approx(
        evaluated_return(checkpoint, "--episodes", "3"), rel=1e-14
    )


def test_the_csv_tells_where_the_hand_went_and_who_moved_it(checkpoint, tmp_path):
    table = tmp_path / "path.csv"
    done = render(checkpoint, "--csv", table)
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["t"]) for row in rows] == list(range(HORIZON + 1))
    assert [int(row["head"]) for row in rows[1:]] == [
        t * HEADS // HORIZON for t in range(HORIZON)
    ]
    assert sum(float(row["reward"]) for row in rows[1:]) == played_return(done)
    assert rows[0]["head"] == rows[0]["reward"] == ""


@pytest.mark.slow
def test_a_video_has_its_frames_and_lasts_as_long_as_the_episode(checkpoint, tmp_path):
    video = tmp_path / "video.mp4"
    done = render(checkpoint, "--out", video, "--size", "320x240", "--every", "5")
    assert played_return(done) == evaluated_return(checkpoint, "--episodes", "1")
    assert [file.name for file in tmp_path.iterdir()] == ["video.mp4"]
    fields = "stream=codec_name,pix_fmt,width,height,nb_read_frames,duration"
    probe = subprocess.run(
        ["ffprobe", "-v", "error", "-count_frames", "-show_entries", fields, "-of", "json", video],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    (stream,) = json.loads(probe.stdout)["streams"]
    frames = HORIZON // 5 + 1
    assert (stream["width"], stream["height"]) == (320, 240)
    assert (stream["codec_name"], stream["pix_fmt"]) == ("h264", "yuv420p")
    assert int(stream["nb_read_frames"]) == frames
    assert float(stream["duration"]) == pytest.approx(frames * 5 / 80, abs=1e-3)


def test_what_cannot_be_is_named_with_the_remedy(checkpoint, tmp_path):
    picture = tmp_path / "picture.png"
    assert ".png" in refusal(2, checkpoint, "--out", tmp_path / "picture.gif")
    assert "no folder" in refusal(1, checkpoint, "--out", tmp_path / "missing" / "picture.png")
    assert "--size" in refusal(2, checkpoint, "--out", picture, "--size", "9x9")
    assert "topview" in refusal(2, checkpoint, "--out", picture, "--camera", "nowhere")
    assert "0 to 50" in refusal(2, checkpoint, "--out", picture, "--step", "51")
    damaged = tmp_path / "damaged.ckpt"
    damaged.write_bytes(checkpoint.read_bytes()[:-1])
    assert "damaged.ckpt" in refusal(1, damaged, "--out", picture)
    assert not picture.exists()


def test_without_ffmpeg_a_video_names_the_package(checkpoint, tmp_path):
    said = refusal(1, checkpoint, "--out", tmp_path / "video.mp4", PATH=str(tmp_path))
    assert "deploy/setup --video" in said
    assert not list(tmp_path.iterdir())


def test_an_ffmpeg_that_fails_is_quoted_and_leaves_nothing(checkpoint, tmp_path):
    (tmp_path / "bin").mkdir()
    fake = tmp_path / "bin" / "ffmpeg"
    fake.write_text("#!/bin/sh\necho no such encoder >&2\nexit 1\n", encoding="utf-8")
    fake.chmod(0o755)
    said = refusal(1, checkpoint, "--out", tmp_path / "video.mp4", PATH=str(tmp_path / "bin"))
    assert "no such encoder" in said
    assert [file.name for file in tmp_path.iterdir()] == ["bin"]


def test_without_osmesa_a_picture_names_the_package(checkpoint, tmp_path):
    (tmp_path / "libOSMesa.so.8").write_bytes(b"no library")
    picture = tmp_path / "picture.png"
    assert "libosmesa6" in refusal(1, checkpoint, "--out", picture, LD_LIBRARY_PATH=str(tmp_path))
    assert not picture.exists()
