"""The systemd units: judged by systemd's own tools, their command lines carried out."""

import os
import re
import shutil
import signal
import subprocess

import pytest

from harness import BUILD, LONG, ROOT, SMALL

UNITS = ROOT / "deploy" / "systemd"
NAMES = ("metronome-learner@.service", "metronome-actor@.service")
analyze = pytest.mark.skipif(
    not shutil.which("systemd-analyze"), reason="systemd-analyze is not installed"
)


def installed(name, folder):
    """A copy of the unit, for run `test`, that finds its programs in this checkout."""
    text = (UNITS / name).read_text().replace("/opt/metronome/build", str(BUILD))
    copy = folder / name.replace("@", "@test")
    copy.write_text(text.replace("/opt/metronome", str(ROOT)))
    return copy


def command_of(name, runs, options):
    """ExecStart as systemd would carry it out, for run `test`."""
    line = re.search(r"^ExecStart=(.*)$", (UNITS / name).read_text(), re.M)[1]
    for old, new in (
        ("/opt/metronome/build", BUILD),
        ("/opt/metronome", ROOT),
        ("/var/lib/metronome", runs),
        ("%i", "test"),
    ):
        line = line.replace(old, str(new))
    words = []
    for word in line.split():
        words += options if word.startswith("$") else [word]
    return words


def signal_of(name):
    return getattr(signal, re.search(r"^KillSignal=(.*)$", (UNITS / name).read_text(), re.M)[1])


@analyze
@pytest.mark.parametrize("name", NAMES)
def test_systemd_finds_no_fault_in_the_unit(name, tmp_path):
    verdict = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", installed(name, tmp_path)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    about_it = [line for line in verdict.stderr.splitlines() if "metronome" in line]
    assert verdict.returncode == 0 and not about_it, verdict.stderr


@analyze
@pytest.mark.parametrize("name", NAMES)
def test_systemd_calls_the_unit_well_confined(name, tmp_path):
    verdict = subprocess.run(
        ["systemd-analyze", "security", "--offline=yes", "--threshold=25", installed(name, tmp_path)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert verdict.returncode == 0, verdict.stdout[-400:] + verdict.stderr


def test_what_a_restart_cannot_mend_is_not_started_again():
    """Usage (2), and an update that is not finite (5): a pure function of what is on disk."""
    unit = (UNITS / NAMES[0]).read_text()
    final = re.search(r"^RestartPreventExitStatus=(.*)$", unit, re.M)[1].split()
    assert final == ["2", "5"]


def test_a_service_that_was_stopped_and_one_that_crashed_go_on_to_the_weights_of_a_calm_run(stage):
    expected = stage.train("calm", small=LONG)
    os.environ["METRONOME_BIN"] = str(BUILD / "bin")
    domain = ["--domain", str(stage.domain)]
    learner_words = command_of(NAMES[0], stage.runs, [*LONG, *domain, "--log-level", "debug"])
    actor = stage.start(*command_of(NAMES[1], stage.runs, domain))

    first = stage.start(*learner_words)
    first.expect_text("joins with")
    first.signal(signal_of(NAMES[0]))
    assert first.wait() == 130, first
    second = stage.start(*learner_words)
    second.expect_text("going on from")
    second.expect_text("joins with")
    second.kill()
    last = stage.start(*learner_words)
    last.expect_text("going on from")
    assert last.wait() == 0, last
    assert stage.inspect(stage.latest("test"))["weights_sha256"] == expected
    assert actor.child.poll() is None, "an actor with --stay waits for the next run"
    actor.signal(signal_of(NAMES[1]))
    assert actor.wait() == 130, actor


def test_a_finished_run_that_is_started_again_ends_well(stage):
    os.environ["METRONOME_BIN"] = str(BUILD / "bin")
    stage.train("test")
    before = stage.inspect(stage.latest("test"))
    again = stage.start(
        *command_of(NAMES[0], stage.runs, [*SMALL, "--domain", str(stage.domain)])
    )
    assert again.wait() == 0, again
    assert stage.inspect(stage.latest("test")) == before
