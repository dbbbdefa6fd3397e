"""Processors without what the build needs are told so, and how to build for them."""

import re
import shutil
import subprocess

import pytest

from harness import ACTOR, BUILD, LEARNER

EMULATOR = shutil.which("qemu-x86_64")
MARCH = re.search(r"^METRONOME_MARCH:STRING=(.*)$", (BUILD / "CMakeCache.txt").read_text(), re.M)[1]
pytestmark = [
    pytest.mark.skipif(EMULATOR is None, reason="qemu-user is not installed (deploy/setup --tests)"),
    pytest.mark.skipif(MARCH != "x86-64-v3", reason=f"the build is for {MARCH}"),
    pytest.mark.parametrize("program", [LEARNER, ACTOR], ids=["learner", "actor"]),
]


def run_on(processor, *command):
    return subprocess.run([EMULATOR, "-cpu", processor, *command], capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["run", "--run", "run"]], ids=" ".join)
def test_a_processor_without_avx2_is_told_what_it_lacks_and_how_to_build_for_it(program, words):
    done = run_on("Nehalem", program, *words)
    assert (done.returncode, done.stdout) == (2, ""), done
    assert "lacks avx avx2 bmi" in done.stderr
    assert "-march=x86-64-v3" in done.stderr
    assert "deploy/setup --march x86-64-v2" in done.stderr


def test_the_build_that_is_advised_is_one_that_the_processor_can_run(program):
    assert "--march x86-64." in run_on("core2duo", program, "--version").stderr
    assert "--march x86-64-v2." in run_on("SandyBridge", program, "--version").stderr


def test_a_processor_that_has_all_is_not_bothered(program):
    done = run_on("Haswell", program, "--version")
    assert done.returncode == 0, done
    assert "lacks" not in done.stderr
