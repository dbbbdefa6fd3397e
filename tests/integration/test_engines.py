"""Two engines never mix in a run; a checkpoint of the other one is said to be so."""

import pytest

from harness import BUILD, ROOT, STEPS

OTHER = ROOT / ("build" if BUILD.name == "build-3.3.0" else "build-3.3.0") / "bin"
pytestmark = pytest.mark.skipif(
    not (OTHER / "metronome-actor").exists(), reason=f"{OTHER} is not built"
)


@pytest.fixture(scope="module")
def finished(module_stage):
    """A stage with a finished run `run` of the engine under test."""
    module_stage.train("run")
    return module_stage


def test_an_actor_of_another_engine_is_turned_away_by_name(stage):
    learner = stage.learner("run")
    learner.expect_event("started")
    stranger = stage.start(
        OTHER / "metronome-actor", "run", "--run", "run", "--domain", stage.domain
    )
    assert stranger.wait() == 1, stranger
    assert "mujoco-2.2.2" in stranger.text, stranger
    assert "mujoco-3.3.0" in stranger.text, stranger
    stage.finish("run", learner, [stage.actor("run")])


def test_resuming_on_another_engine_is_refused(finished):
    command = [OTHER / "metronome-learner", *finished.processes[0].command[1:], "--resume"]
    refused = finished.start(*command)
    assert refused.wait() not in (0, None), refused
    assert "mujoco-2.2.2" in refused.text, refused
    assert "mujoco-3.3.0" in refused.text, refused
    assert finished.inspect(finished.latest("run"))["steps"] == STEPS


def test_evaluating_on_another_engine_warns(finished):
    evaluate = finished.start(
        OTHER / "metronome-actor",
        *("evaluate", "--checkpoint", finished.latest("run"), "--episodes", "1", "--json"),
    )
    assert evaluate.wait() == 0, evaluate
    assert "warn" in evaluate.text.lower(), evaluate
    report = evaluate.json()
    assert report["engine_trained"] != report["engine_used"]
