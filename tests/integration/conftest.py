import pytest

from harness import Stage
from unread import unread  # noqa: F401  (a fixture)


@pytest.fixture
def stage(request, tmp_path):
    stage = Stage(request.node.nodeid, tmp_path)
    yield stage
    stage.close()


@pytest.fixture(scope="module")
def module_stage(request, tmp_path_factory):
    """For what several tests of a file compare with; outlives each of them."""
    stage = Stage(request.node.nodeid, tmp_path_factory.mktemp("module"))
    yield stage
    stage.close()
