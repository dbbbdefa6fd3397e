"""As many actor processes as a machine of a group may have, on this one."""

EPISODES, HORIZON, UPDATES, ACTORS = 64, 50, 12, 64
SETTINGS = (
    *("--task", "push", "--seed", "7", "--horizon", str(HORIZON)),
    *("--steps", str(EPISODES * HORIZON * UPDATES), "--set", "ppo.minibatch=400"),
    *("--set", f"collection.episodes_per_update={EPISODES}"),
)


def run(stage, name, actors):
    """@return weights_sha256 and the learner, whose actors were all there from the first assignment on."""
    team = [stage.actor(name) for _ in range(actors)]  # first: else those of a busy machine come when the run is over
    learner = stage.learner(name, small=SETTINGS)
    assert learner.wait() == 0, learner
    for actor in team:
        assert actor.wait() == 0, actor
    return stage.inspect(stage.latest(name))["weights_sha256"], learner


def test_sixty_four_actor_processes_give_the_weights_of_one(stage):
    expected, _ = run(stage, "one", 1)
    weights, learner = run(stage, "many", ACTORS)
    assert learner.text.count(" joins with 1 env") == ACTORS, learner
    assert weights == expected
