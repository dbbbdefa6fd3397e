"""tests/fresh/run without what makes it long: `debootstrap` makes a root of a shell alone, and the two commands are
those of a checkout of three files."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

import namespaces
from harness import ROOT

pytestmark = pytest.mark.skipif(namespaces.unavailable() is not None, reason=str(namespaces.unavailable()))

DEBOOTSTRAP = """#!/bin/bash
set -eu
for word; do case $word in /*) root=$word; break ;; esac; done
mkdir -p "$root"/{proc,sys,dev,root,bin,etc/apt/apt.conf.d,etc/dpkg/dpkg.cfg.d}
for program in bash sh env sleep; do
  path=$(command -v $program)
  cp -L "$path" "$root/bin/"
  ldd "$path" | grep -o '/[^ ]*' | xargs -I{} cp -L -n --parents {} "$root"
done
for program in update-ca-certificates apt-get; do printf '#!/bin/sh\\n' >"$root/bin/$program"; done
chmod 755 "$root"/bin/*
"""
TRAIN = """#!/bin/bash
trap 'echo an interrupt arrives' INT
kill -INT $$
echo "trained $1, index $PIP_INDEX_URL, secret ${SECRET-none}"
"""
ENDLESS = "#!/bin/bash\necho waiting\nsleep 987654\n"


@pytest.fixture
def checkout(tmp_path):
    checkout = tmp_path / "check out"
    (checkout / "tests" / "fresh").mkdir(parents=True)
    (checkout / "deploy").mkdir()
    for name in ("run", "root.sh"):
        shutil.copy(ROOT / "tests" / "fresh" / name, checkout / "tests" / "fresh")
    program(tmp_path / "bin" / "debootstrap", DEBOOTSTRAP)
    commit(checkout, TRAIN, "#!/bin/bash\necho '7 passed, 0 failed'\n")
    return checkout


def program(path, text):
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


def commit(checkout, train, tests):
    program(checkout / "deploy" / "train", train)
    program(checkout / "tests" / "run", tests)
    git = ("git", "-C", checkout, "-c", "user.name=a", "-c", "user.email=a")
    for words in (("init", "-q"), ("add", "."), ("commit", "-q", "-m", "all")):
        subprocess.run([*git, *words], check=True)


@pytest.fixture
def fresh(stage, checkout, monkeypatch):
    """Starts tests/fresh/run of the checkout."""
    monkeypatch.setenv("PATH", f"{checkout.parent / 'bin'}:{os.environ['PATH']}")
    for name in ("SSL_CERT_DIR", "PIP_FIND_LINKS"):  # folders that would be copied
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PIP_INDEX_URL", "our-own")
    monkeypatch.setenv("SECRET", "of this machine")
    return lambda *options: stage.start(checkout / "tests" / "fresh" / "run", *options)


def result_of(checkout):
    return (checkout / "tests" / "fresh" / "last.txt").read_text()


def test_the_two_commands_run_on_the_new_machine_and_the_result_is_kept(checkout, fresh):
    process = fresh()
    assert process.wait() == 0, process
    result = result_of(checkout)
    revision = subprocess.run(["git", "-C", checkout, "rev-parse", "HEAD"], capture_output=True, text=True).stdout.strip()
    for words in (revision, "processor", "deploy/train push", "tests/run", "    7 passed, 0 failed",
                  "    trained push, index our-own, secret none", "    an interrupt arrives"):
        assert words in result, result
    assert result.count("exit status 0") == 4, result
    assert "trained push" in (checkout / ".cache" / "fresh" / "run.log").read_text()
    assert not (checkout / ".cache" / "fresh" / "machine").exists()


@pytest.mark.parametrize("failing", ["train", "tests"])
def test_a_command_that_fails_is_a_failure_and_the_other_one_is_still_tried(checkout, fresh, failing):
    bad, good = "#!/bin/bash\necho it broke\nexit 3\n", "#!/bin/bash\necho it works\n"
    commit(checkout, *((bad, good) if failing == "train" else (good, bad)))
    process = fresh()
    assert process.wait() == 1, process
    result = result_of(checkout)
    assert "exit status 3\n    it broke" in result and "exit status 0\n    it works" in result, result
    assert not (checkout / ".cache" / "fresh" / "machine").exists()


def test_without_a_debian_it_fails_and_says_why(checkout, fresh):
    program(checkout.parent / "bin" / "debootstrap", "#!/bin/sh\necho no such mirror\nexit 1\n")
    process = fresh()
    assert process.wait() == 1, process
    assert "exit status 1\n    no such mirror" in result_of(checkout)
    assert "deploy/train" not in result_of(checkout)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_when_it_is_stopped_nothing_stays_of_the_new_machine(checkout, fresh, number):
    commit(checkout, ENDLESS, ENDLESS)
    process = fresh()
    process.expect_text("waiting")
    machine = checkout / ".cache" / "fresh" / "machine"
    inside = [entry for entry in Path("/proc").glob("[0-9]*") if is_root_of(entry, machine)]
    assert inside
    process.signal(number)
    assert process.wait() == (130 if number == signal.SIGINT else 143), process
    assert not machine.exists() and not any(entry.exists() for entry in inside)


def is_root_of(process, folder):
    try:
        return os.path.samefile(process / "root", folder)
    except OSError:
        return False


def test_it_is_kept_where_that_is_asked_for(checkout, fresh):
    process = fresh("--keep")
    assert process.wait() == 0, process
    assert (checkout / ".cache" / "fresh" / "machine" / "root" / "metronome" / "tests" / "run").exists()
