"""The stage of tests/integration: real processes, deadlines, a DDS domain of its own."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "integration"))
from harness import Stage  # noqa: E402


@pytest.fixture
def stage(request, tmp_path):
    stage = Stage(request.node.nodeid, tmp_path)
    yield stage
    stage.close()
