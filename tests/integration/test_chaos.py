"""One run under faults ends like a calm one. All twenty: tests/chaos/run."""

import subprocess
import sys
from pathlib import Path

import pytest

import namespaces
from harness import ROOT


@pytest.mark.skipif(not Path("/dev/net/tun").exists(), reason="no TUN devices here")
@pytest.mark.skipif(namespaces.unavailable() is not None, reason=str(namespaces.unavailable()))
@pytest.mark.slow
def test_a_run_under_faults_ends_with_the_weights_of_a_calm_one(tmp_path):
    done = subprocess.run(
        [sys.executable, "-B", ROOT / "tests" / "chaos", "--seeds", "1", "--logs", tmp_path],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    assert "1 passed, 0 failed" in done.stdout
