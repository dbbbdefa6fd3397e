"""What is installed: it runs from any folder, without the checkout, and says one version. A Debian package of it is
installed by tests/fresh/package."""

import re
import subprocess

import pytest

import namespaces
from harness import BUILD, ROOT, SMALL, UPDATES

AWAY = 'mount -t tmpfs none "$0" && exec "$@"'  # with an empty folder in the checkout's place


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """An installation that was moved since."""
    folder = tmp_path_factory.mktemp("prefix")
    subprocess.run(["cmake", "--install", BUILD, "--prefix", folder / "first"], check=True, capture_output=True)
    return (folder / "first").rename(folder / "second place")


@pytest.fixture
def say(stage, prefix, tmp_path):
    """Runs an installed command from another folder, with nothing of this environment. @return the process, ended."""
    away = () if namespaces.mounts_unavailable() else ("unshare", "--mount", "sh", "-c", AWAY, ROOT)

    def run(program, *words):
        path = program if "/" in program else f"bin/{program}"
        process = stage.start("env", "-i", "-C", tmp_path, f"PATH={prefix}/bin:/usr/bin:/bin", *away, prefix / path, *words)
        process.wait()
        return process

    return run


def engine():
    (found,) = re.findall(r"^METRONOME_MUJOCO:\w+=(.*)", (BUILD / "CMakeCache.txt").read_text(), re.MULTILINE)
    return found


def test_version_changelog_and_citation_say_one_version(say):
    (version,) = re.findall(r"^project\(metronome VERSION (\S+)", text("CMakeLists.txt"), re.MULTILINE)
    newest, date = re.findall(r"^## \[(.*)\] - (\S+)", text("CHANGELOG.md"), re.MULTILINE)[0]
    citation = dict(re.findall(r"^([\w-]+): (\S+)", text("CITATION.cff"), re.MULTILINE))
    assert (newest, citation["version"], citation["date-released"]) == (version, version, date)
    for program in ("metronome-learner", "metronome-actor"):
        said = say(program, "--version").text
        assert said.startswith(f"metronome {version}, ") and said.endswith(f", mujoco-{engine()}"), said


def test_no_program_names_the_checkout(prefix):
    for program in (prefix / "bin").iterdir():
        assert str(ROOT).encode() not in program.read_bytes(), program


def test_what_is_installed_trains_and_evaluates_in_any_folder(say, stage, tmp_path):
    run = say("metronome-train", "push", *SMALL[2:], "--run", "first", "--actors", "1", "--domain", stage.domain)
    assert run.child.returncode == 0 and "  evaluate    metronome-actor evaluate --checkpoint runs/first/" in run.text, run
    latest = tmp_path / "runs" / "first" / "checkpoints" / "latest"
    assert say("metronome-learner", "inspect", latest, "--json").json()["version"] == UPDATES
    judged = say("metronome-actor", "evaluate", "--checkpoint", latest, "--episodes", "1", "--json").json()
    assert (judged["episodes"], judged["differences"]) == (1, [])


def test_a_policy_of_an_older_version_is_evaluated_without_a_warning(say, tmp_path):
    name = "push" if engine() == "2.2.2" else "assembly"
    policy = tmp_path / f"{name}.ckpt"
    policy.write_bytes((ROOT / "results" / "policies" / policy.name).read_bytes())
    judged = say("metronome-actor", "evaluate", "--checkpoint", policy, "--episodes", "1", "--json").json()
    assert judged["differences"] == []


def test_another_engine_than_the_installed_one_is_refused_by_name(say):
    other = "3.3.0" if engine() == "2.2.2" else "2.2.2"
    process = say("metronome-train", "push", "--mujoco", other)
    assert process.child.returncode == 2, process
    assert f"metronome-train: error: argument --mujoco: the installed programs have MuJoCo {engine()}, not {other}" in process.text


def test_what_else_is_installed_finds_its_parts(say, tmp_path):
    assert say("metronome-security", "ours", "--run", "one", "--actors", "1").child.returncode == 0
    assert (tmp_path / "ours" / "actor-0").is_dir()
    for words in (("metronome-train", "--help"), ("share/metronome/learner", "runs", "one", "--help")):
        process = say(*words)
        assert process.child.returncode == 0 and "--steps" in process.text, process
