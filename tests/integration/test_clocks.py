"""Clocks that jump: NTP steps them, people set them. The time of day must decide nothing."""

import os
import subprocess
from pathlib import Path

import pytest

LIBRARY = next(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)
JUMPS = ["+400d", "-400d", "+5s"]

pytestmark = pytest.mark.skipif(LIBRARY is None, reason="needs Debian's package libfaketime")


class Clock:
    """The time of day of processes that are started through it; others keep theirs."""

    def __init__(self, path):
        self._path = path
        self.jump("+0")

    def process(self, *command):
        """@return the command line that runs it by this clock: a `host` to Stage."""
        return (
            *("env", f"LD_PRELOAD={LIBRARY}", f"FAKETIME_TIMESTAMP_FILE={self._path}"),
            # No system's monotonic clock jumps.
            *("FAKETIME_NO_CACHE=1", "FAKETIME_DONT_FAKE_MONOTONIC=1"),
            *command,
        )

    def jump(self, offset):
        """From the true time, for example "-2d"."""
        new = self._path.with_suffix(".new")
        new.write_text(offset + "\n")
        os.replace(new, self._path)


@pytest.fixture(scope="module")
def expected(module_stage):
    return module_stage.train("calm")


def test_the_time_of_day_does_jump(tmp_path):
    clock = Clock(tmp_path / "clock")
    years = []
    for offset in ("+0", "-800d"):
        clock.jump(offset)
        shown = subprocess.run(clock.process("date", "+%Y"), check=True, capture_output=True)
        years.append(int(shown.stdout))
    assert years[0] - years[1] in (2, 3)


@pytest.mark.parametrize("whose", ["learner", "actor"])
@pytest.mark.slow
def test_a_clock_that_jumps_changes_nothing_and_delays_nothing(stage, tmp_path, expected, whose):
    clock = Clock(tmp_path / "clock")
    hosts = {whose: clock}
    learner = stage.learner("run", host=hosts.get("learner"))
    actor = stage.actor("run", host=hosts.get("actor"))
    jumping = {"learner": learner, "actor": actor}[whose]
    learner.expect_update(1)
    assert LIBRARY.name in Path(f"/proc/{jumping.child.pid}/maps").read_text()
    for offset in JUMPS:
        learner.expect_update(learner.updates() + 1, seconds=20)
        clock.jump(offset)
    assert stage.finish("run", learner, [actor]) == expected
