"""The logs of both processes with --log-format json: an object a line, and nothing else."""

import json

from harness import DEADLINE


def logged(process):
    """@return the objects on standard error; fails if anything else is there."""
    results = [line.rstrip("\n") for line in process.output]
    told = list(process.lines)
    for line in results:
        told.remove(line)
    return [json.loads(line) for line in told]


def test_both_processes_log_json_objects_alone(stage):
    learner = stage.learner("run", "--log-format", "json")
    actor = stage.actor("run", "--log-format", "json")
    stage.finish("run", learner, [actor])
    for process, name, word in ((learner, "learner", "joins"), (actor, "actor", "joined run")):
        said = logged(process)
        assert any(word in line["message"] for line in said), process
        for line in said:
            assert set(line) == {"time", "level", "process", "pid", "message"}
            assert (line["process"], line["pid"]) == (name, process.child.pid)


def test_an_unknown_format_is_answered_with_the_known_ones(stage):
    for process in (
        stage.learner("run", "--log-format", "jsno"),
        stage.actor("run", "--log-format", "jsno"),
    ):
        assert process.wait(DEADLINE) == 2, process
        assert "json" in process.text and "text" in process.text, process
