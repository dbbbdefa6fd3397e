"""deploy/figures as one command."""

import hashlib
import shutil
import subprocess

import pytest

import policies
import synthetic
from conftest import ROOT


def figures(*arguments, code=0):
    done = subprocess.run([ROOT / "deploy" / "figures", *map(str, arguments)], capture_output=True, text=True,
                          timeout=200)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def digests(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    synthetic.main_experiment(folder, seeds=3, tasks=["push"], updates=20)
    runs = folder / "main" / "runs.jsonl"
    *finished, _, _ = runs.read_text().splitlines(keepends=True)  # without seeds 2 and 3 of push-ppo-time
    runs.write_text("".join(finished))
    synthetic.cell(folder, "later", "reach", "some-arm", 1)
    return folder


def test_the_same_results_give_the_same_bytes(results, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- table final -->\nold\n<!-- end -->\n<!-- figure main -->\n<!-- end -->\nafter\n")
    said = figures("--results", results, "--out", tmp_path / "a", "--page", page)
    assert "main/push-ppo-time-s3 is not finished" in said and "main: 7 runs" in said
    figures("--results", results, "--out", tmp_path / "b")
    made = digests(tmp_path / "a")
    assert made == digests(tmp_path / "b")
    assert {"main.png", "main-success.png", "ablation.png", "final.png", "efficiency.png", "wallclock.png",
            "later-curves.png", "README.md"} == set(made)
    assert all(path.stat().st_size < 300_000 for path in (tmp_path / "a").iterdir())
    text = page.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "old" not in text
    assert "| push | PPO | 3 | " in text and "![main](a/main.png)" in text


@pytest.mark.parametrize("form", ["svg", "pdf"])
def test_vector_figures_have_the_same_bytes_too(results, tmp_path, form):
    for name in ("a", "b"):
        figures("--results", results, "--out", tmp_path / name, "--only", "later-curves", "--format", form)
    assert digests(tmp_path / "a") == digests(tmp_path / "b")
    assert list(digests(tmp_path / "a")) == [f"later-curves.{form}"]


def test_no_results_exit_with_two(tmp_path):
    assert "no finished run" in figures("--results", tmp_path, code=2)
    assert not (tmp_path / "figures").exists()


def test_a_damaged_file_exits_with_two_and_is_named(tmp_path):
    files = synthetic.cell(tmp_path, "main", "push", "multihead", 1)
    with open(files.progress_path("push"), "a") as file:
        file.write("1,2\n")
    assert "main/progress/push.csv:52:" in figures("--results", tmp_path, code=2)


def test_an_unknown_figure_is_answered_with_those_there_are(results, tmp_path):
    said = figures("--results", results, "--out", tmp_path / "a", "--only", "mian", code=2)
    assert "'mian'" in said and "main-success" in said and "later-curves" in said


def test_a_page_with_a_mark_that_nothing_fills_is_refused(results, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("<!-- table finale -->\n<!-- end -->\n")
    assert "<!-- table finale -->" in figures("--results", results, "--page", page, code=2)
    assert not (results / "figures").exists()


def test_a_committed_policy_gets_a_picture_of_its_skills(results, tmp_path):
    shutil.copytree(results, tmp_path / "results")
    (tmp_path / "results" / "policies").mkdir()
    shutil.copy(ROOT / "results" / "policies" / "push.ckpt", tmp_path / "results" / "policies")
    page = tmp_path / "page.md"
    page.write_text("<!-- figure skill-push -->\n<!-- end -->\n")
    figures("--results", tmp_path / "results", "--only", "skill-push", "--page", page)
    assert (tmp_path / "results" / "figures" / "skill-push.png").read_bytes().startswith(b"\x89PNG")
    assert "![skill-push](results/figures/skill-push.png)" in page.read_text()
    (tmp_path / "results" / "policies" / "push.ckpt").write_bytes(b"no checkpoint")
    assert "push.ckpt: " in figures("--results", tmp_path / "results", "--only", "skill-push", code=1)


def test_pictures_are_drawn_by_the_default_engine_alone(tmp_path):
    for build in ("build-3.3.0", "build"):
        assert policies.renderer(tmp_path) is None
        (tmp_path / build / "bin").mkdir(parents=True)
        (tmp_path / build / "bin" / "metronome-actor").touch()
    assert policies.renderer(tmp_path) == tmp_path / "build" / "bin" / "metronome-actor"


def test_a_cell_on_another_engine_is_compared_with_itself(tmp_path):
    for experiment, level in (("main", 0.7), ("engine", 0.3)):
        for seed in (1, 2, 3):
            synthetic.cell(tmp_path / "results", experiment, "push", "multihead", seed, level=level, updates=20)
    page = tmp_path / "page.md"
    page.write_text("<!-- table engine -->\n<!-- end -->\n")
    figures("--results", tmp_path / "results", "--out", tmp_path / "out", "--page", page)
    row = next(line for line in page.read_text().splitlines() if "push" in line)
    assert "| 3, 3 | paired | -" in row, row


def test_a_caption_says_the_episode_and_no_file(tmp_path):
    program = tmp_path / "metronome-actor"
    program.write_text("#!/bin/sh\necho 'push, weights version 250: return 4723.1, success'\necho wrote skill.png\n")
    program.chmod(0o755)
    said = policies.render(program, tmp_path / "push.ckpt", tmp_path / "skill.png")
    assert policies.caption(said).endswith(" Push, weights version 250: return 4723.1, success.")
