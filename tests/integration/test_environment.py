"""An environment that learner/ and common/ do not know (tests/environment/): the same learner program learns it,
since it asks the actor program beside it. Its episodes end early."""

import csv
import json
import shutil

import pytest

from harness import ACTOR, BUILD, LEARNER, ROOT

# Solved in a few seconds, by PPO and by SAC. The best possible return is 1, whatever the start.
REACH = ("--task", "point", "--heads", "3", "--steps", "40000", "--seed", "1", "--set", "policy.hidden=32,32",
         "--set", "collection.episodes_per_update=64", "--set", "ppo.minibatch=256", "--set", "ppo.learning_rate=2e-3")
REACH_BY_SAC = ("--task", "point", "--algorithm", "sac", "--heads", "3", "--steps", "15000", "--seed", "1",
                "--set", "environment.reward=REWARD_OFFICIAL", "--set", "policy.hidden=32,32",
                "--set", "collection.episodes_per_update=32", "--set", "sac.random_episodes=64",
                "--set", "sac.critic_hidden=64,64", "--set", "sac.batch=128", "--set", "sac.replay_ratio=24",
                "--set", "sac.actor_learning_rate=2e-3", "--set", "sac.critic_learning_rate=2e-3",
                "--set", "sac.target_std=0.3", "--set", "sac.n_step=3")
BEST = 1.0


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """A folder of programs whose actor has another table of environments."""
    folder = tmp_path_factory.mktemp("build") / "bin"
    folder.mkdir()
    shutil.copy2(LEARNER, folder)
    (folder / "metronome-actor").symlink_to(BUILD / "bin" / "reach-actor")
    return folder


class Play:
    def __init__(self, stage, programs):
        self.stage, self.programs = stage, programs

    def learner(self, run, *options, training=REACH):
        return self.stage.start(self.programs / "metronome-learner", "run", "--run", run, "--runs", self.stage.runs,
                                "--domain", self.stage.domain, "--progress", "json", *training, *options)

    def actor(self, run, *options):
        return self.stage.start(self.programs / "metronome-actor", "run", "--run", run, "--domain", self.stage.domain,
                                *options)

    def rows(self, run):
        with open(self.stage.runs / run / "progress.csv", newline="") as file:
            return [{name: value for name, value in row.items() if name != "fps" and not name.startswith("wall_")}
                    for row in csv.DictReader(file)]

    def evaluate(self, checkpoint):
        done = self.stage.start(self.programs / "metronome-actor", "evaluate", "--checkpoint", checkpoint, "--json")
        assert done.wait() == 0, done
        return json.loads("".join(done.output))


@pytest.fixture(scope="module")
def one(module_stage, programs):
    """The run on one actor."""
    play = Play(module_stage, programs)
    learner, actor = play.learner("one"), play.actor("one")
    assert learner.wait() == 0, learner
    assert actor.wait() == 0, actor
    return play


def state_of(play, run):
    return play.stage.inspect(play.stage.latest(run))


def expect_learnt(play, run):
    """To nine tenths of what is possible."""
    rows = play.rows(run)
    report = play.evaluate(play.stage.latest(run))
    print(f"return: random policy {float(rows[0]['return']):.3f}, learnt {report['return']:.3f}, best {BEST}")
    assert report["task"] == "point"
    assert report["return"] >= 0.9 * BEST > 0.9 * float(rows[0]["return"])
    assert report["success"] >= 0.9
    assert 5 <= report["length"] < 20


@pytest.mark.slow
def test_it_is_learnt_to_nine_tenths_of_what_is_possible(one):
    expect_learnt(one, "one")


@pytest.mark.slow
def test_sac_learns_it_too(stage, programs):
    play = Play(stage, programs)
    learner, actor = play.learner("sac", training=REACH_BY_SAC), play.actor("sac")
    assert learner.wait() == 0, learner
    assert actor.wait() == 0, actor
    expect_learnt(play, "sac")


def test_steps_are_those_taken_and_the_run_ends_with_the_update_that_reaches_its_total(one):
    rows = one.rows("one")
    steps = [int(row["steps"]) for row in rows]
    lengths = [(after - before) / 64 for before, after in zip([0, *steps], steps)]
    assert min(lengths) >= 5 and max(lengths) <= 60 and max(lengths) > 2 * min(lengths), lengths
    assert steps[-2] < 40000 <= steps[-1]
    assert float(rows[-1]["learning_rate"]) == pytest.approx(2e-3 * max(0.1, 1 - steps[-2] / 40000))
    state = state_of(one, "one")
    assert (state["steps"], state["version"], state["episodes_used"]) == (steps[-1], len(rows), 64 * len(rows))


@pytest.mark.parametrize("actors", [2, 3])
@pytest.mark.slow
def test_more_actors_one_of_them_killed_give_the_same_bits(stage, programs, one, actors):
    play = Play(stage, programs)
    learner = play.learner("run")
    team = [play.actor("run", *(("--envs", "2") if i == 1 else ())) for i in range(actors)]
    learner.expect_update(3)
    team[0].kill()
    assert learner.wait() == 0, learner
    for actor in team[1:]:
        assert actor.wait() == 0, actor
    assert state_of(play, "run")["weights_sha256"] == state_of(one, "one")["weights_sha256"]
    assert play.rows("run") == one.rows("one")


@pytest.mark.slow
def test_a_killed_learner_goes_on_to_the_same_bits(stage, programs, one):
    play = Play(stage, programs)
    learner, actor = play.learner("run"), play.actor("run")
    learner.expect_update(3)
    learner.kill()
    learner = play.learner("run", "--resume")
    assert learner.wait() == 0, learner
    assert actor.wait() == 0, actor
    assert state_of(play, "run")["weights_sha256"] == state_of(one, "one")["weights_sha256"]
    assert play.rows("run") == one.rows("one")


def test_an_unknown_name_is_answered_by_the_actor_program(stage, programs):
    learner = stage.start(programs / "metronome-learner", "config", "--task", "poin")
    assert learner.wait() == 2
    learner.expect_text('--task: environment.task is an unknown environment "poin"; did you mean "point"?')


def test_an_actor_without_the_environment_says_so(stage, programs):
    play = Play(stage, programs)
    learner = play.learner("run")
    actor = stage.actor("run")
    assert actor.wait() == 2, actor
    actor.expect_text('unknown environment "point"')
    learner.kill()


@pytest.mark.slow
def test_what_is_not_in_mujoco_cannot_be_drawn(one):
    render = one.stage.start(one.programs / "metronome-actor", "render", "--checkpoint", one.stage.latest("one"),
                             "--csv", one.stage.runs / "path.csv")
    assert render.wait() == 2
    render.expect_text("environment point cannot be drawn: it is not in MuJoCo")


def test_every_name_that_is_listed_is_described(stage):
    listed = stage.start(ACTOR, "environment")
    assert listed.wait() == 0
    assert "push" in "".join(listed.output).split()
    for name in "".join(listed.output).split():
        described = stage.start(ACTOR, "environment", name)
        assert described.wait() == 0
        assert f'short_name: "{name}"\n' in described.output


def test_neither_learner_nor_common_knows_it():
    for folder in ("learner", "common", "idl"):
        for path in (ROOT / folder).rglob("*"):
            assert not path.is_file() or "\"point\"" not in path.read_text().lower(), path
