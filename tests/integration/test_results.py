"""The results of a run, and the part of them that may differ between two runs."""

import csv
import signal

import pytest

from harness import ACTOR, LONG, LONG_UPDATES, STEPS, UPDATES

REQUIRED = {"steps", "return", "success", "success_end", "fps"}


def rows(stage, run):
    with open(stage.runs / run / "progress.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def without_clock(records):
    """Rows less the columns that are wall-clock time: those marked so, and `fps`."""
    return [
        {
            name: value
            for name, value in record.items()
            if name != "fps" and not name.startswith("wall_")
        }
        for record in records
    ]


@pytest.fixture(scope="module")
def finished(module_stage):
    """A stage with a finished run named `whole`."""
    module_stage.train("whole", actors=2)
    return module_stage


def test_a_run_leaves_everything_that_the_readme_names(finished):
    folder = finished.runs / "whole"
    assert (folder / "config.textproto").is_file()
    assert (folder / "checkpoints" / "latest").exists()
    assert list(folder.glob("**/events.out.tfevents*"))
    records = rows(finished, "whole")
    assert len(records) == UPDATES
    assert REQUIRED <= set(records[0])
    assert int(records[-1]["steps"]) == STEPS


def test_every_episode_number_entered_exactly_one_update(finished):
    episodes = STEPS // 50
    finished.processes[0].expect_text(
        f"every episode number entered exactly one update: {episodes} of {episodes}", seconds=1
    )


def test_two_runs_differ_in_wall_clock_columns_alone(finished, stage):
    stage.train("again")
    assert without_clock(rows(stage, "again")) == without_clock(rows(finished, "whole"))


@pytest.mark.slow
def test_a_resumed_run_cuts_its_logs_and_writes_the_same_ones(finished, stage):
    learner, actor = stage.learner("run"), stage.actor("run")
    learner.expect_update(4)
    learner.kill()
    # The checkpoint may be older than the last row written: make sure that it is.
    checkpoint = stage.latest("run").resolve()
    earlier = sorted(
        checkpoint.parent.glob(checkpoint.name.translate(str.maketrans("0123456789", "?" * 10)))
    )[-3]
    stage.latest("run").unlink()
    stage.latest("run").symlink_to(earlier.name)
    for newer in sorted(checkpoint.parent.glob("*.ckpt")):
        if newer.name > earlier.name:
            newer.unlink()
    stage.finish("run", stage.learner("run", "--resume"), [actor])
    assert without_clock(rows(stage, "run")) == without_clock(rows(finished, "whole"))


def test_a_finished_run_resumed_with_more_steps_is_refused(finished):
    longer = [
        str(2 * STEPS) if word == str(STEPS) else word for word in finished.processes[0].command
    ]
    refused = finished.start(*longer, "--resume")
    assert refused.wait() != 0, refused
    assert "total_steps" in refused.text or "steps" in refused.text, refused


@pytest.mark.parametrize("place", ["start", "middle", "end", "cut"])
def test_a_damaged_checkpoint_loads_nothing(finished, tmp_path, place):
    data = bytearray(finished.latest("whole").read_bytes())
    if place == "cut":
        del data[-100:]
    else:
        data[{"start": 2, "middle": len(data) // 2, "end": len(data) - 1}[place]] ^= 1
    damaged = tmp_path / "damaged.ckpt"
    damaged.write_bytes(data)
    inspect = finished.start(finished.processes[0].command[0], "inspect", damaged, "--json")
    assert inspect.wait() != 0, inspect
    assert "damaged.ckpt" in inspect.text, inspect


def test_evaluation_reads_the_checkpoint_and_repeats_itself(finished):
    evaluate = (ACTOR, "evaluate", "--checkpoint", finished.latest("whole"), "--episodes", "2")
    first, second = (finished.start(*evaluate, "--json") for _ in range(2))
    assert first.wait() == 0, first
    assert second.wait() == 0, second
    report = first.json()
    assert report == second.json()
    assert report["episodes"] == 2
    assert {"success", "success_end", "success_200", "return", "engine_trained", "engine_used"} <= set(report)


@pytest.mark.slow
def test_a_resume_after_sigterm_keeps_one_row_an_update(stage):
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(2)
    learner.signal(signal.SIGTERM)
    assert learner.wait() == 143, learner
    stage.finish("run", stage.learner("run", "--resume", small=LONG), [actor], LONG_UPDATES)
    steps = [int(record["steps"]) for record in rows(stage, "run")]
    assert steps == [STEPS // UPDATES * (i + 1) for i in range(LONG_UPDATES)]
