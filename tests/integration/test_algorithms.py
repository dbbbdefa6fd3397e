"""An algorithm that the project does not have, behind the seam that PPO is behind: tests/algorithm."""

import csv

import pytest

from harness import ACTOR, BUILD, LEARNER, LONG_UPDATES
from harness import LONG as LONG_PPO
from harness import SMALL as SMALL_PPO

SMALL, LONG = (tuple(words[:-2]) for words in (SMALL_PPO, LONG_PPO))  # without ppo.minibatch
CUSTOM = ("--set", "custom.name=cross-entropy", "--set", "custom.settings=2",
          "--set", "policy.initial_log_std=0", "--set", "policy.hidden=4")


@pytest.fixture
def crossed(stage):
    """A stage whose learners know the cross-entropy method."""
    stage.learner_program = str(BUILD / "bin" / "cross-entropy-learner")
    return stage


@pytest.mark.slow
def test_learner_and_actors_carry_it_to_the_same_bits_whoever_plays(crossed):
    # Long enough for the second actor to take part: these updates take no time.
    one = crossed.train("one", *CUSTOM, small=LONG)
    assert crossed.train("two", *CUSTOM, actors=2, small=LONG) == one
    rows = list(csv.DictReader((crossed.runs / "one" / "progress.csv").open()))
    assert list(rows[0])[:7] == ["steps", "update", "episodes", "return", "success", "success_end", "best_return"]
    assert float(rows[-1]["best_return"]) >= float(rows[-1]["return"]) > 0


@pytest.mark.slow
def test_a_learner_killed_and_resumed_changes_nothing(crossed):
    whole = crossed.train("whole", *CUSTOM, small=LONG)
    learner, actor = crossed.learner("run", *CUSTOM, small=LONG), crossed.actor("run")
    learner.expect_update(3)
    learner.kill()
    assert 2 <= crossed.inspect(crossed.latest("run"))["version"] < LONG_UPDATES
    resumed = crossed.learner("run", *CUSTOM, "--resume", small=LONG)
    assert crossed.finish("run", resumed, [actor], LONG_UPDATES) == whole


def test_whoever_does_not_know_it_can_still_play_and_inspect_what_it_learnt(crossed):
    crossed.train("run", *CUSTOM, small=SMALL)
    held = crossed.inspect(crossed.latest("run"))  # by the real program
    assert (held["algorithm"], held["algorithm_format"], held["critic_parameters"]) == ("cross-entropy", 1, 0)
    evaluated = crossed.start(ACTOR, "evaluate", "--checkpoint", crossed.latest("run"), "--episodes", "2", "--json")
    assert evaluated.wait() == 0, evaluated
    assert evaluated.json()["version"] == held["version"]


def test_a_learner_that_does_not_know_it_says_which_it_knows(stage):
    learner = stage.learner("run", *CUSTOM, small=SMALL)
    assert learner.wait() == 2, learner
    assert 'unknown algorithm "cross-entropy"' in learner.text and "ppo" in learner.text, learner
    assert not (stage.runs / "run").exists()


def test_a_run_keeps_its_algorithm(crossed):
    crossed.train("run", *CUSTOM, small=SMALL)
    resume = (LEARNER, "run", "--run", "run", "--runs", crossed.runs, "--resume")
    refused = crossed.start(*resume, "--set", "ppo.clip=0.1")
    assert refused.wait() == 2, refused
    assert "ppo.clip: custom is set already" in refused.text, refused
    (crossed.runs / "run" / "ppo.cfg").write_text("ppo {}")
    refused = crossed.start(*resume, "--config", crossed.runs / "run" / "ppo.cfg")
    assert refused.wait() == 2, refused
    assert "the algorithm: the run has cross-entropy, asked for ppo" in refused.text, refused
