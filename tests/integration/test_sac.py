"""SAC keeps PPO's promises: the same weights however a run is carried out, its replay included."""

import csv
import random
import time

import pytest

from harness import ACTOR, LEARNER, LONG_UPDATES
from harness import LONG as LONG_PPO
from harness import SMALL as SMALL_PPO

SMALL, LONG = (tuple(words[:-2]) for words in (SMALL_PPO, LONG_PPO))  # without ppo.minibatch
SAC = ("--algorithm", "sac", "--set", "sac.batch=32", "--set", "sac.replay_ratio=0.5", "--set", "sac.random_episodes=6",
       "--set", "sac.critic_hidden=32", "--set", "policy.hidden=32", "--set", "sac.replay_steps=1000")
WAITING = (*SAC, "--set", "collection.overlap=0")


@pytest.fixture(scope="module")
def expected(module_stage):
    """weights_sha256 of the run on one actor, one learner that never stopped."""
    return module_stage.train("one-actor", *SAC, small=LONG)


def test_two_actors_give_the_weights_of_one(stage, expected):
    assert stage.train("run", *SAC, actors=2, small=LONG) == expected
    rows = list(csv.DictReader((stage.runs / "run" / "progress.csv").open()))
    assert [int(row["replay_steps"]) for row in rows[:6]] == [200, 400, 600, 800, 1000, 1000]
    assert int(rows[0]["gradient_steps"]) == 0  # of random actions
    assert int(rows[-1]["gradient_steps"]) in (3, 4)  # 0.5 * 200 / 32


@pytest.mark.slow
def test_three_actors_and_two_episodes_at_once_give_the_weights_of_one(stage, expected):
    assert stage.train("run", *SAC, actors=3, actor_options=("--envs", "2"), small=LONG) == expected


@pytest.mark.slow
def test_shared_memory_gives_the_weights_of_udp(stage, expected):
    shm = ("--transport", "shm")
    assert stage.train("run", *SAC, *shm, actors=2, actor_options=shm, small=LONG) == expected


@pytest.mark.slow
def test_waiting_runs_agree_among_themselves(stage, expected):
    waiting = stage.train("one", *WAITING, small=LONG)
    assert waiting != expected
    assert stage.train("two", *WAITING, actors=2, small=LONG) == waiting


@pytest.mark.slow
def test_an_actor_killed_and_another_joining_change_nothing(stage, expected):
    learner, victim = stage.learner("run", *SAC, small=LONG), stage.actor("run", "--envs", "2")
    learner.expect_update(8)
    victim.kill()
    assert learner.child.poll() is None, "the run ended before the actor was killed"
    assert stage.finish("run", learner, [stage.actor("run")], LONG_UPDATES) == expected


@pytest.mark.parametrize("checkpoint_every", ["1", "4"])
@pytest.mark.slow
def test_a_learner_killed_and_resumed_goes_on_with_its_replay(stage, expected, checkpoint_every):
    every = ("--checkpoint-every", checkpoint_every)
    learner, actor = stage.learner("run", *SAC, *every, small=LONG), stage.actor("run")
    for update in (8, 20):
        learner.expect_update(update)
        learner.kill()
        learner = stage.learner("run", *SAC, *every, "--resume", small=LONG)
    assert stage.finish("run", learner, [actor], LONG_UPDATES) == expected


@pytest.mark.slow
def test_a_learner_killed_at_random_instants_goes_on_to_the_same_weights(stage, expected):
    seed = random.randrange(2**32)
    print(f"seed of the instants: {seed}")
    instants = random.Random(seed)
    learner, actor = stage.learner("run", *SAC, small=LONG), stage.actor("run")
    for update in sorted(instants.sample(range(1, LONG_UPDATES - 4), 3)):
        learner.expect_update(update)
        time.sleep(instants.uniform(0, 0.1))  # an instant within an update, not a wait for anything
        learner.kill()
        learner = stage.learner("run", *SAC, "--resume", small=LONG)
    assert stage.finish("run", learner, [actor], LONG_UPDATES) == expected


@pytest.mark.slow
def test_it_begins_with_the_networks_of_another_run(stage):
    stage.train("source", *SAC, small=tuple("8" if word == "7" else word for word in SMALL))
    begun = (*SAC, "--from", stage.latest("source"))
    one = stage.train("one", *begun, "--set", "runtime.checkpoint_keep=100", small=LONG)
    first = stage.inspect(stage.runs / "one" / "checkpoints" / "000000.ckpt")
    assert first["initial_weights_sha256"] == stage.inspect(stage.latest("source"))["weights_sha256"]
    assert first["steps"] == 0
    learner, actor = stage.learner("two", *begun, small=LONG), stage.actor("two")
    learner.expect_update(8)
    learner.kill()
    resumed = stage.learner("two", *begun, "--resume", small=LONG)
    assert stage.finish("two", resumed, [actor], LONG_UPDATES) == one
    for words in ("sac.bins=51", "sac.critic_hidden=16", "sac.value_limit=9"):
        refused = stage.learner("new", *begun, "--set", words, small=LONG)
        assert refused.wait() == 2 and f"its {words.split('=')[0]} is" in refused.text, refused
        assert not (stage.runs / "new").exists()


def cut_short(stage):
    """A run that was killed; the checkpoint that it would go on from."""
    learner, actor = stage.learner("run", *SAC, small=LONG), stage.actor("run")
    learner.expect_update(8)
    learner.kill()
    actor.kill()
    return stage.runs / "run" / "replay" / "000000000000.episodes"


def refused(stage):
    learner = stage.learner("run", *SAC, "--resume", small=LONG)
    assert learner.wait() == 2, learner
    return learner.text


def test_a_replay_that_is_missing_damaged_or_another_runs_is_refused_by_name(stage):
    segment = cut_short(stage)
    whole = segment.read_bytes()
    segment.write_bytes(whole[:1000] + b"x" + whole[1001:])
    assert f"{segment}: damaged at byte 0" in refused(stage)
    segment.unlink()
    assert "replay holds 0 of the" in refused(stage)
    assert "begin anew under another --run" in refused(stage)
    stage.train("other", *SAC, small=tuple("8" if word == "7" else word for word in SMALL))
    segment.write_bytes((stage.runs / "other" / "replay" / segment.name).read_bytes() * 2)
    assert "replay" in refused(stage)
    segment.write_bytes(whole)
    resumed, actor = stage.learner("run", *SAC, "--resume", small=LONG), stage.actor("run")
    stage.finish("run", resumed, [actor], LONG_UPDATES)


def test_its_checkpoints_are_inspected_and_evaluated_and_no_other_algorithms(stage):
    stage.train("run", *SAC, small=SMALL)
    held = stage.inspect(stage.latest("run"))
    assert held["algorithm"] == "sac" and held["head_std"] == []
    evaluated = stage.start(ACTOR, "evaluate", "--checkpoint", stage.latest("run"), "--episodes", "2", "--json")
    assert evaluated.wait() == 0, evaluated
    resume = (LEARNER, "run", "--run", "run", "--runs", stage.runs, "--resume")
    other = stage.start(*resume, "--algorithm", "ppo")
    assert other.wait() == 2 and "--algorithm ppo: the configuration has settings of sac" in other.text, other
    begun = stage.learner("new", "--from", stage.latest("run"), "--set", "policy.hidden=32", small=SMALL)
    assert begun.wait() == 2 and "its algorithm is sac, this run's is ppo" in begun.text, begun


def test_methods_have_their_own_names(stage):
    learner = stage.learner("run", *SAC, "--method", "ppo-time", small=SMALL)
    assert learner.wait() == 2, learner
    assert "--method ppo-time: the algorithm is sac; its methods are multihead, single and single-time" in learner.text
