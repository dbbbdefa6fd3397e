"""The same run gives the same weights, bit for bit, however it is carried out."""

import pytest

from harness import LONG, LONG_UPDATES, SMALL

OVERLAP = ("--set", "collection.overlap=1")


@pytest.fixture(scope="module")
def expected(module_stage):
    """weights_sha256 of the run on one actor."""
    return module_stage.train("one-actor")


@pytest.fixture(scope="module")
def expected_long(module_stage):
    return module_stage.train("long", small=LONG)


@pytest.fixture(scope="module")
def expected_overlapping(module_stage):
    return module_stage.train("overlapping", *OVERLAP, small=LONG)


@pytest.mark.slow
def test_two_actors_give_the_weights_of_one(stage, expected):
    assert stage.train("run", actors=2) == expected


@pytest.mark.slow
def test_three_actors_give_the_weights_of_one(stage, expected):
    assert stage.train("run", actors=3) == expected


@pytest.mark.slow
def test_two_episodes_at_once_in_an_actor_give_the_weights_of_one(stage, expected):
    assert stage.train("run", actor_options=("--envs", "2")) == expected


def test_shared_memory_gives_the_weights_of_udp(stage, expected):
    shm = ("--transport", "shm")
    assert stage.train("run", *shm, actors=2, actor_options=shm) == expected


@pytest.mark.slow
def test_one_learner_thread_gives_the_weights_of_all_cores(stage, expected):
    assert stage.train("run", "--set", "runtime.learner_threads=1") == expected


@pytest.mark.slow
def test_another_seed_gives_other_weights(stage, expected):
    small = tuple("8" if word == "7" else word for word in SMALL)
    assert stage.train("run", small=small) != expected


@pytest.mark.slow
def test_an_actor_started_before_the_learner_joins_it(stage, expected):
    actor = stage.actor("run")
    actor.expect_text("learner")
    learner = stage.learner("run")
    assert stage.finish("run", learner, [actor]) == expected


@pytest.mark.slow
def test_an_actor_that_joins_late_changes_nothing(stage, expected_long):
    learner, first = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(2)
    late = stage.actor("run")
    assert learner.wait() == 0, learner
    assert first.wait() == 0, first
    # It may have come too late to be seen by the learner; then it finds the run finished or gone.
    late.kill()
    assert stage.inspect(stage.latest("run"))["weights_sha256"] == expected_long


@pytest.mark.slow
def test_an_actor_killed_and_another_joining_change_nothing(stage, expected_long):
    learner, victim = stage.learner("run", small=LONG), stage.actor("run", "--envs", "2")
    learner.expect_update(2)
    victim.kill()
    assert learner.child.poll() is None, "the run ended before the actor was killed"
    assert stage.finish("run", learner, [stage.actor("run")], LONG_UPDATES) == expected_long


@pytest.mark.slow
def test_a_learner_killed_and_resumed_changes_nothing(stage, expected_long):
    learner, actor = stage.learner("run", small=LONG), stage.actor("run")
    learner.expect_update(3)
    learner.kill()
    killed_at = stage.inspect(stage.latest("run"))["version"]
    assert 2 <= killed_at < LONG_UPDATES
    resumed = stage.learner("run", "--resume", small=LONG)
    assert stage.finish("run", resumed, [actor], LONG_UPDATES) == expected_long


@pytest.mark.slow
def test_overlapping_runs_agree_among_themselves(stage, expected_long, expected_overlapping):
    assert expected_overlapping != expected_long
    assert stage.train("run", *OVERLAP, actors=3, small=LONG) == expected_overlapping


@pytest.mark.slow
def test_an_overlapping_learner_killed_and_resumed_changes_nothing(stage, expected_overlapping):
    learner, actor = stage.learner("run", *OVERLAP, small=LONG), stage.actor("run")
    learner.expect_update(3)
    learner.kill()
    resumed = stage.learner("run", *OVERLAP, "--resume", small=LONG)
    assert stage.finish("run", resumed, [actor], LONG_UPDATES) == expected_overlapping


@pytest.mark.parametrize("method", ["ppo", "ppo-time"])
@pytest.mark.slow
def test_one_head_methods_agree_too(stage, method):
    alone = stage.train("one", "--method", method)
    assert stage.train("two", "--method", method, actors=2) == alone


@pytest.mark.parametrize(
    "arm",
    [
        ("policy.schedule=interleaved",),
        ("policy.schedule=shuffled",),
        ("policy.critic_heads=shared",),
        ("policy.schedule=shuffled", "policy.critic_heads=shared", "collection.overlap=1"),
        ("ppo.time_limit_value=bootstrap",),
        ("policy.noise_correlation=0",),
        ("policy.noise_correlation=0.8", "collection.check_share=0.5"),
        ("ppo.shared_heads=false", "policy.critic_time=false", "ppo.min_std=0", "ppo.std_decay=0",
         "ppo.log_std_rate=3", "ppo.reward_scale_decay=0.95"),
        ("ppo.success_weight=2", "ppo.earlier_batches=2", "collection.overlap=1"),
        # T = 100, k = 20, as many steps in as many updates
        (
            "environment.horizon=100",
            "policy.heads=20",
            "collection.episodes_per_update=2",
            "ppo.time_limit_value=bootstrap",
        ),
    ],
    ids=lambda arm: " ".join(arm),
)
@pytest.mark.slow
def test_two_actors_give_the_weights_of_one_in_every_arm(stage, expected, arm):
    options = [word for setting in arm for word in ("--set", setting)]
    alone = stage.train("one", *options)
    assert alone != expected
    assert stage.train("two", *options, actors=2) == alone


@pytest.mark.slow
def test_a_shuffled_learner_killed_and_resumed_changes_nothing(stage):
    shuffled = ("--set", "policy.schedule=shuffled")
    alone = stage.train("alone", *shuffled, small=LONG)
    learner, actor = stage.learner("run", *shuffled, small=LONG), stage.actor("run", "--envs", "2")
    learner.expect_update(3)
    learner.kill()
    resumed = stage.learner("run", *shuffled, "--resume", small=LONG)
    assert stage.finish("run", resumed, [actor], LONG_UPDATES) == alone
