"""deploy/setup on checkouts and processors that are not as its author's: what it needs is said before it starts."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from harness import ROOT

NOBODY = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups")
needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="being somebody else needs root")
BUILD_FILE = """rule copy
  command = cp $in $out
build program: copy ../source
build programs: phony program
"""


def program(path, text):
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


@pytest.fixture
def place():
    """A folder that everybody can read, as pytest's own are not."""
    folder = Path(tempfile.mkdtemp(prefix="metronome-test-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture
def checkout(place):
    """One that is set up: with set-up's files and a build of one file, `source`."""
    checkout = place / "check out"
    checkout.mkdir()
    shutil.copytree(ROOT / "deploy", checkout / "deploy", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("CMakePresets.json", "common/compile_options.cmake"):
        (checkout / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, checkout / name)
    scenes = checkout / ".cache" / "metaworld-3.1.1" / "assets"
    scenes.mkdir(parents=True)
    (scenes / ".stamp").write_text(re.search(r"sha256:[0-9a-f]+", (ROOT / "deploy" / "metaworld.txt").read_text())[0])
    (checkout / "source").touch()
    (checkout / "build").mkdir()
    (checkout / "build" / "CMakeCache.txt").write_text("METRONOME_MARCH:STRING=x86-64-v3\n")
    (checkout / "build" / "build.ninja").write_text(BUILD_FILE)
    subprocess.run(["ninja", "-C", checkout / "build", "programs"], check=True, capture_output=True)
    return checkout


def files(checkout):
    return {path: path.lstat().st_mtime_ns for path in checkout.rglob("*")}


def run(checkout, *words, by=(), path=None):
    """@return what the command of this checkout said and how it ended; `path` comes before all other programs."""
    environment = dict(os.environ, HOME="/nonexistent")
    if path:
        environment["PATH"] = f"{path}:{environment['PATH']}"
    return subprocess.run([*by, checkout / words[0], *words[1:]], env=environment, cwd="/", capture_output=True,
                          text=True, timeout=60)


def read_only(checkout):
    """@return what runs a command where the checkout's file system is read-only."""
    script = 'mount --bind "$0" "$0" && mount -o remount,bind,ro "$0" && exec "$@"'
    return ("unshare", "--mount", "sh", "-c", script, checkout)


@needs_root
@pytest.mark.parametrize("by", [lambda checkout: NOBODY, read_only], ids=["another user's", "read-only"])
def test_a_checkout_that_is_set_up_is_used_without_writing_to_it(checkout, by):
    before = files(checkout)
    done = run(checkout, "deploy/setup", by=by(checkout))
    assert done.returncode == 0, done.stderr
    assert "up to date" in done.stdout
    assert files(checkout) == before


@needs_root
@pytest.mark.parametrize("by", [lambda checkout: NOBODY, read_only], ids=["another user's", "read-only"])
@pytest.mark.parametrize(
    "spoil",
    [
        lambda checkout: (checkout / "build" / "program").unlink(),
        lambda checkout: shutil.rmtree(checkout / "build"),
        lambda checkout: shutil.rmtree(checkout / ".cache"),
        lambda checkout: (checkout / "build" / "CMakeCache.txt").write_text("METRONOME_MARCH:STRING=x86-64-v2\n"),
    ],
    ids=["a program", "the build", "the scene files", "another processor"],
)
def test_what_is_missing_in_a_checkout_that_cannot_be_written_is_said_with_the_ways_out(checkout, by, spoil):
    spoil(checkout)
    before = files(checkout)
    done = run(checkout, "deploy/setup", "--march", "x86-64-v3", by=by(checkout))
    assert done.returncode == 1, done.stdout + done.stderr
    for word in ("deploy/setup --march x86-64-v3", "--build", "--runs", "git clone", str(checkout)):
        assert word in done.stderr, done.stderr
    assert "line " not in done.stderr, done.stderr
    assert files(checkout) == before


@needs_root
@pytest.mark.parametrize("setup", ["deploy/plots/setup", "deploy/growth/setup"])
def test_packages_that_are_not_there_cannot_be_put_into_anothers_checkout(checkout, setup):
    done = run(checkout, setup, by=NOBODY)
    assert done.returncode == 1 and "which nobody cannot" in done.stderr, done.stderr
    assert f"run this there: {setup}" in done.stderr, done.stderr


@needs_root
@pytest.mark.parametrize("options", [("--run", "mine"), ("--run", "his", "--resume"), ()], ids=["new", "resumed", "unnamed"])
def test_runs_that_cannot_be_kept_are_refused_before_anything_is_set_up(checkout, options):
    shutil.rmtree(checkout / "build")
    (checkout / "runs" / "his" / "checkpoints").mkdir(parents=True)
    (checkout / "runs").chmod(0o700 if options else 0o755)
    done = run(checkout, "deploy/train", "push", *options, by=NOBODY)
    assert done.returncode == 2, done.stderr
    assert f"cannot write to {checkout}/runs" in done.stderr and "--runs DIR" in done.stderr, done.stderr


@pytest.fixture
def build(checkout):
    """One whose learner ends with 7."""
    (checkout / "made").mkdir()
    for name in ("learner", "actor"):
        program(checkout / "made" / "bin" / f"metronome-{name}", "exit 7")
    return checkout / "made"


@needs_root
def test_a_run_of_ones_own_is_gone_on_with_in_a_folder_of_somebody_elses(checkout, build):
    own = checkout / "runs" / "mine" / "checkpoints"
    own.mkdir(parents=True)
    for path in (own, own.parent):
        os.chown(path, 65534, 65534)
    done = run(checkout, "deploy/train", "push", "--build", build, "--run", "mine", "--resume", by=NOBODY)
    assert done.returncode == 7, done.stderr


@needs_root
@pytest.mark.parametrize("option", ["--config", "--from", "--build", "--security", "--runs"])
def test_what_cannot_be_looked_into_is_named(checkout, place, build, option):
    closed = place / "closed"
    closed.mkdir(mode=0o700)
    options = {"--runs": "/tmp", "--build": build} | {option: closed / "inside"}
    done = run(checkout, "deploy/train", "push", *(word for pair in options.items() for word in pair), by=NOBODY)
    assert done.returncode == (1 if option == "--security" else 2), done.stderr
    assert str(closed) in done.stderr and "Traceback" not in done.stderr, done.stderr


@needs_root
def test_an_experiment_whose_results_cannot_be_kept_is_refused(checkout):
    done = run(checkout, "deploy/experiment", checkout / "deploy/experiments/main.toml", "--runs", "/tmp", by=NOBODY)
    assert done.returncode == 2, done.stderr
    assert f"cannot write to {checkout}/results" in done.stderr and "--results DIR" in done.stderr, done.stderr


@needs_root
def test_an_exchange_whose_rows_cannot_be_kept_is_refused(checkout):
    program(checkout / "bin" / "metronome-actor", "exit 1")
    (checkout / "results" / "exchange").mkdir(parents=True)
    done = run(checkout, "deploy/exchange", "any.ckpt", "--build", checkout, by=NOBODY)
    assert done.returncode == 1, done.stderr
    assert f"cannot write to {checkout}/results/exchange" in done.stderr and "--out DIR" in done.stderr, done.stderr


@pytest.fixture
def old_processor(checkout):
    """Programs of a machine without AVX2, where cmake only notes what it is asked for."""
    programs = checkout.parent / "bin"
    program(programs / "ld.so", 'echo "  x86-64-v3"; echo "  x86-64-v2 (supported, searched)"')
    program(programs / "cmake", 'printf "%s\\n" "$@" >asked; for word; do case $word in METRONOME_MARCH=*) '
                                'echo "METRONOME_MARCH:STRING=${word#*=}" >build/CMakeCache.txt; esac; done')
    return programs


@pytest.mark.parametrize("built", [True, False], ids=["built", "new"])
def test_on_a_processor_without_avx2_it_says_what_to_build_before_it_does_anything(checkout, old_processor, built):
    if not built:
        shutil.rmtree(checkout / "build")
    before = files(checkout)
    done = run(checkout, "deploy/setup", "--quiet", "--mujoco", "2.2.2", path=old_processor)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "AVX2" in done.stderr and "deploy/setup --march x86-64-v2 --mujoco 2.2.2\n" in done.stderr, done.stderr
    assert files(checkout) == before


def test_it_builds_for_the_kind_of_processor_that_is_named_and_keeps_to_it(checkout, old_processor):
    for options in (("--march", "x86-64-v2"), ()):
        done = run(checkout, "deploy/setup", *options, path=old_processor)
        assert done.returncode == 0, done.stderr
    asked = (checkout / "asked").read_text().splitlines()
    assert "METRONOME_MARCH=x86-64-v2" in asked and "release" in asked
    assert "configuring" not in done.stdout, done.stdout


def test_a_kind_of_processor_that_no_compiler_knows_is_refused(checkout):
    done = run(checkout, "deploy/setup", "--march", "x86-64-v33")
    assert done.returncode == 2 and "'x86-64-v33'" in done.stderr, done.stderr
    assert "x86-64-v3\n" in (checkout / "build" / "CMakeCache.txt").read_text()


def test_what_the_commands_are_written_in_can_be_installed_without_all_the_rest(checkout):
    programs = checkout.parent / "bin"
    program(programs / "dpkg-query", "exit 1")  # knows no package
    program(programs / "apt-get", 'echo "$@" >>"$(dirname "$0")/installed"')
    done = run(checkout, "deploy/setup", "--python", path=programs)
    assert done.returncode == 0, done.stderr
    asked = (programs / "installed").read_text()
    assert "python3" in asked and "g++" not in asked
