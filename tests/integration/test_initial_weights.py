"""--from: a new run that begins with another run's weights."""

import csv

import pytest

from harness import BUILD, HORIZON, ROOT, SMALL, UPDATES

USAGE = 2  # exit code
# Another task and another seed than the source's.
NEXT = ("--task", "assembly", *(word if word != "7" else "8" for word in SMALL[2:]))
KEEP = ("--set", "runtime.checkpoint_keep=100")


@pytest.fixture(scope="module")
def source(module_stage):
    """A checkpoint."""
    module_stage.train("source")
    return module_stage.latest("source")


@pytest.fixture(scope="module")
def expected(module_stage, source):
    """weights_sha256 of a run that began with it."""
    return module_stage.train("next", "--from", source, *KEEP, small=NEXT)


@pytest.mark.slow
def test_it_begins_with_the_weights_and_nothing_else(module_stage, source, expected):
    stage, given = module_stage, module_stage.inspect(source)
    first = stage.inspect(stage.runs / "next" / "checkpoints" / "000000.ckpt")
    assert first["weights_sha256"] == given["weights_sha256"] == first["initial_weights_sha256"]
    assert (first["version"], first["steps"], first["task"], first["seed"]) == (0, 0, "assembly", 8)
    assert first["initial_weights"] == str(source)
    with open(stage.runs / "next" / "progress.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert int(rows[0]["steps"]) == 4 * HORIZON and len(rows) == UPDATES
    assert float(rows[0]["learning_rate"]) > float(rows[-1]["learning_rate"])
    assert stage.train("unlike", small=NEXT) != expected


@pytest.mark.parametrize("overlap", [(), ("--set", "collection.overlap=1")], ids=["", "overlapping"])
@pytest.mark.slow
def test_on_two_actors_killed_and_resumed_it_has_the_same_bits(stage, module_stage, source, expected, overlap):
    if overlap:
        expected = module_stage.train("overlapping", "--from", source, *overlap, small=NEXT)
    words = ("--from", source, *overlap)
    learner = stage.learner("run", *words, small=NEXT)
    team = [stage.actor("run"), stage.actor("run")]
    learner.expect_update(2)
    learner.kill()
    # The same command goes on; and so does one without the weights' name.
    resumed = stage.learner("run", "--resume", *(words if overlap else ()), small=NEXT)
    assert stage.finish("run", resumed, team) == expected


def test_what_differs_is_said(stage, source):
    learner = stage.learner("run", "--from", source, "--set", "policy.schedule=interleaved", small=NEXT)
    learner.expect_text("environment.task: trained with push, this run has assembly")
    said = learner.expect_text("policy.schedule: trained with blocks, this run has interleaved")
    assert "warning" in said
    learner.kill()


def test_weights_that_do_not_fit_are_refused_before_anything_is_made(stage, source, tmp_path):
    torn = tmp_path / "torn.ckpt"
    torn.write_bytes(source.read_bytes()[:1000])
    for words, says in (
        (("--from", source, "--heads", "5"), "policy.heads is 10, this run's is 5"),
        (("--from", source, "--method", "ppo"), "policy.method is multihead, this run's is single"),
        (("--from", torn), f"{torn}: damaged"),
        (("--from", tmp_path / "none.ckpt"), "none.ckpt: No such file"),
    ):
        learner = stage.learner("run", *words, small=NEXT)
        assert learner.wait(60) == USAGE, learner
        assert says in learner.text, learner
    assert not (stage.runs / "run").exists()


def test_a_run_goes_on_with_no_other_weights_than_it_began_with(stage, source):
    learner = stage.learner("run", small=NEXT)
    learner.expect_event("started")
    learner.kill()
    other = stage.learner("run", "--resume", "--from", source, small=NEXT)
    assert other.wait(60) == USAGE, other
    assert f"policy.initial_weights: the run has none, asked for {source}" in other.text, other


@pytest.mark.slow
def test_the_launcher_takes_it_and_its_own_word_of_how_to_go_on(stage, source, expected):
    words = (ROOT / "deploy" / "train", *NEXT[1:], "--build", BUILD, "--runs", stage.runs, "--domain", stage.domain)
    missing = stage.start(*words, "--run", "run", "--from", source.with_name("none.ckpt"))
    assert missing.wait(60) == USAGE and "none.ckpt" in missing.text, missing
    launcher = stage.start(*words, "--run", "run", "--from", source, "--actors", 1)
    assert launcher.wait() == 0, launcher
    again = stage.start(*words, "--run", "run", "--from", source, "--actors", 1, "--resume")
    assert again.wait() == 0, again
    assert stage.inspect(stage.latest("run"))["weights_sha256"] == expected
