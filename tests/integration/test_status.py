"""A running run seen from another process: metronome-learner status."""

import signal

import pytest

from harness import ENDLESS, LEARNER, UPDATES, parse_json


def status(stage, run, *options):
    return stage.start(LEARNER, "status", run, "--domain", stage.domain, *options)


@pytest.mark.slow
def test_a_running_run_is_shown_with_its_actors_as_a_table_and_as_json(stage):
    learner = stage.learner("seen", small=ENDLESS)
    actor = stage.actor("seen", "--envs", 2)
    learner.expect_update(2)
    follower = status(stage, "seen", "--json", "--follow")
    shown = follower.expect(
        lambda line: parse_json(line) if parse_json(line).get("actors") else None, "an actor"
    )
    assert shown["run_name"] == "seen" and shown["task"] == "push"
    assert shown["pid"] == learner.child.pid
    assert -1 < shown["age_seconds"] < 3
    assert shown["actors_total"] == 1 and shown["envs_total"] == 2
    assert shown["actors"][0]["name"].endswith(f":{actor.child.pid}")
    table = status(stage, "seen")
    assert table.wait() == 0, table
    assert f":{actor.child.pid}" in table.text and "1 actor with 2 envs" in table.text
    learner.signal(signal.SIGINT)
    assert learner.wait() == 130
    assert follower.wait() == 0, follower
    assert parse_json(follower.output[-1])["state"] == "stopped"


@pytest.mark.slow
def test_following_ends_with_the_run(stage):
    learner = stage.learner("ends")
    learner.expect_event("started")
    follower = status(stage, "ends", "--json", "--follow")
    follower.expect(lambda line: parse_json(line).get("run_name"), "a status")
    actor = stage.actor("ends")
    stage.finish("ends", learner, [actor])
    assert follower.wait() == 0, follower
    last = parse_json(follower.output[-1])
    assert (last["state"], last["version"]) == ("finished", UPDATES)
    assert last["checkpoint_version"] == UPDATES


def test_a_learner_that_is_not_there_ends_with_3_and_what_to_try(stage):
    nobody = status(stage, "nobody", "--wait", "0.5")
    assert nobody.wait() == 3, nobody
    for words in ("nobody", f"domain {stage.domain}", "network loopback", "another machine"):
        assert words in nobody.text


@pytest.mark.slow
def test_an_actor_that_hears_no_learner_says_early_what_to_try(stage):
    learner = stage.learner("near", small=ENDLESS)
    learner.expect_event("started")
    actor = stage.actor("near", "--network", "lan", "--learner-timeout", 6)
    said = actor.expect_text("on that machine leave --network out")
    assert "giving up" not in said and f"domain {stage.domain}, network lan" in said
    assert actor.wait() == 3, actor
    assert stage.actor("near", "--learner-timeout", 60).expect_text("joined run 'near'")


def test_status_takes_the_name_as_an_option_too(stage):
    learner = stage.learner("named", small=ENDLESS)
    said = learner.expect_text("watch it with: metronome-learner status")
    words = said.partition("watch it with: ")[2].split()[1:]
    assert words == ["status", "named", "--domain", str(stage.domain)]
    shown = stage.start(LEARNER, "status", "--run", *words[1:])
    assert shown.wait() == 0 and "run named " in shown.text, shown


@pytest.mark.slow
def test_a_killed_learner_ends_following_with_3(stage):
    learner = stage.learner("killed")
    learner.expect_event("started")
    follower = status(stage, "killed", "--json", "--follow")
    follower.expect(lambda line: parse_json(line).get("run_name"), "a status")
    learner.kill()
    assert follower.wait() == 3, follower
    follower.expect_text("is gone")
