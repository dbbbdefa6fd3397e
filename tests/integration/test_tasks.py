"""Several tasks in one run: the same bits on any number of actors, figures by task everywhere."""

import csv
import json

import pytest

from harness import ACTOR, EPISODES, LEARNER, SMALL

TASKS = ("assembly", "push", "bin-picking", "box-close")
assert len(TASKS) == EPISODES
SEVERAL = tuple(",".join(TASKS) if word == "push" else word for word in SMALL)


@pytest.fixture(scope="module")
def one(module_stage):
    """weights_sha256 of the run on one actor."""
    return module_stage.train("one", small=SEVERAL)


def rows_of(stage, run):
    with open(stage.runs / run / "progress.csv", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
@pytest.mark.parametrize("by", ["time", "task", "task-time"])
def test_more_actors_one_of_them_killed_give_the_same_bits(stage, by):
    heads = ("--set", f"policy.heads_by={by}", *(("--set", "policy.heads=1") if by == "task" else ()))
    expected = stage.train("one", *heads, small=SEVERAL)
    for actors in (2, 3):
        run = f"on-{actors}"
        learner = stage.learner(run, *heads, small=SEVERAL)
        team = [stage.actor(run, *(("--envs", "2") if i == 1 else ())) for i in range(actors)]
        learner.expect_update(3)
        team[0].kill()
        assert stage.finish(run, learner, team[1:]) == expected


@pytest.mark.slow
def test_a_killed_learner_goes_on_to_the_same_bits(stage, one):
    learner, actor = stage.learner("run", small=SEVERAL), stage.actor("run")
    learner.expect_update(3)
    learner.kill()
    learner = stage.learner("run", "--resume", small=SEVERAL)
    assert stage.finish("run", learner, [actor]) == one


def test_progress_has_a_column_of_each_task_whose_mean_is_that_of_all(module_stage, one):
    for row in rows_of(module_stage, "one"):
        for figure in ("return", "success"):
            each = [float(row[f"{figure}_{task}"]) for task in TASKS]
            assert float(row[figure]) == pytest.approx(sum(each) / len(each))
    assert len({row[f"return_{task}"] for row in rows_of(module_stage, "one") for task in TASKS}) > 20  # no two tasks, no two updates alike


def test_an_evaluation_has_the_figures_of_each_task(module_stage, one):
    def evaluate(*options):
        done = module_stage.start(ACTOR, "evaluate", "--checkpoint", module_stage.latest("one"), "--json", "--episodes",
                                  "3", *options)
        assert done.wait() == 0, done
        return json.loads("".join(done.output))

    report = evaluate()
    assert report["episodes"] == 3 * len(TASKS) and list(report["tasks"]) == list(TASKS)
    assert report["return"] == pytest.approx(sum(task["return"] for task in report["tasks"].values()) / len(TASKS))
    alone = evaluate("--task", "push")
    assert "tasks" not in alone
    assert all(alone[figure] == value for figure, value in report["tasks"]["push"].items())


def test_a_task_that_the_policy_does_not_know_is_refused_by_name(module_stage, one):
    done = module_stage.start(ACTOR, "evaluate", "--checkpoint", module_stage.latest("one"), "--task", "door-open")
    assert done.wait() == 2
    done.expect_text("--task door-open: the policy was trained on assembly, push, bin-picking, box-close")


def test_a_picture_is_of_one_task(module_stage, one):
    def render(*options):
        return module_stage.start(ACTOR, "render", "--checkpoint", module_stage.latest("one"), "--csv",
                                  module_stage.runs / "path.csv", *options)

    assert render("--task", "push").wait() == 0
    several = render()
    assert several.wait() == 2
    several.expect_text("an episode is of one task: name it by --task")


@pytest.mark.parametrize(("options", "reason"), [
    (("--task", "push,push-v3"), 'impossible list "push,push-v3": push is in it twice'),
    (("--task", "push,asembly"), 'unknown environment "asembly"; did you mean "assembly"?'),
    (("--task", "push,assembly", "--placements", "fixed"), "must be random, mt1"),
    (("--task", "push,assembly", "--placements", "benchmark"), "push,assembly is none"),
    (("--task", "push,assembly", "--set", "collection.episodes_per_update=7"), "must be a multiple, as 8"),
    (("--task", "push", "--set", "policy.heads_by=task"), "that takes several tasks"),
    (("--task", "push,assembly", "--set", "policy.heads_by=task", "--heads", "3"), "with heads by task each has 1"),
    (("--task", "push,assembly", "--set", "policy.heads_by=task-time", "--method", "single"), "takes the method multihead"),
])
def test_what_cannot_be_is_refused_by_name(stage, options, reason):
    learner = stage.start(LEARNER, "config", *options)
    assert learner.wait() == 2
    learner.expect_text(reason)
