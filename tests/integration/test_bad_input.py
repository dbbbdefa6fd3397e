"""Bad input is named, with the remedy, before anything starts; usage errors exit 2."""

import contextlib

import pytest

import namespaces
from harness import ACTOR, LEARNER


@pytest.mark.parametrize(
    "options, says",
    [
        (("--task", "pussh"), ("push", "assembly", "bin-picking", "box-close")),
        (("--task", "push", "--method", "multihaed"), ("multihead", "ppo-time")),
        (("--task", "push", "--set", "policy.schedule=interlaved"), ('"interleaved"', "shuffled")),
        (("--task", "push", "--set", "policy.critic_heads=one"), ("separate", "shared")),
        (("--task", "push", "--set", "ppo.clipp=0.1"), ('"clip"', "kl_stop")),
        (("--task", "push", "--set", "pp.clip=0.1"), ("ppo",)),
        (("--task", "push", "--set", "ppo.clip"), ("ppo.clip",)),
        (("--task", "push", "--set", "ppo.clip=wide"), ("ppo.clip", "wide")),
        (("--task", "push", "--heads", "501"), ("501", "500")),
        (("--task", "push", "--heads", "0"), ("heads",)),
        (("--task", "push", "--set", "ppo.minibatch=-5"), ("minibatch",)),
        (("--task", "push", "--set", "ppo.learning_rate=nan"), ("learning_rate",)),
        (("--task", "push", "--set", "policy.initial_log_std=inf"), ("initial_log_std",)),
        (("--task", "push", "--domain", "500"), ("domain",)),
        (("--task", "push", "--transport", "tpc"), ("udp", "shm", '"tcp"')),
        (("--task", "push", "--transport", "tcp", "--network", "lan"), ("--network HOST[:PORT]",)),
        (("--task", "push", "--discovery-server", "127.0.0.1"), ("--network lan",)),
        (("--task", "push", "--discovery-server", "a:b", "--network", "lan"), ("a:b", "port")),
        (("--task", "push", "--network", "::1"), ("--network", "'::1': IPv6 is not supported")),
        (("--task", "push", "--network", "10.0.0.7,[::1]:7400"), ("'[::1]:7400': IPv6 is not",)),
        (("--task", "push", "--network", "udp://10.0.0.7"), ("is a URL: give HOST[:PORT] alone",)),
        (("--task", "push", "--network", "10.0.0.7,,10.0.0.8"), ("nothing stands here",)),
        (("--task", "push", "--network", "no-such-host.invalid"), ("no IPv4 address is known",)),
        (("--task", "push", "--metrics", "[::1]:9464"), ("--metrics", "IPv6 is not supported")),
        (("--task", "push", "--bogus"), ("--bogus",)),
    ],
    ids=lambda value: "_".join(value) if isinstance(value, tuple) else None,
)
def test_the_learner_names_it_and_exits_2(stage, options, says):
    learner = stage.start(LEARNER, "run", "--run", "run", "--runs", stage.runs, *options)
    assert learner.wait(30) == 2, learner
    for word in says:
        assert word in learner.text, learner
    assert not (stage.runs / "run").exists()


def test_a_configuration_file_is_judged_by_line_and_column(stage, tmp_path):
    config = tmp_path / "mine.textproto"
    config.write_text('environment { task: "push" }\nppo {\n  clipp: 0.1\n}\n', encoding="utf-8")
    learner = stage.start(LEARNER, "run", "--run", "run", "--runs", stage.runs, "--config", config)
    assert learner.wait(30) == 2, learner
    assert f"{config}:3:" in learner.text, learner


def test_an_existing_run_needs_resume(stage):
    first = stage.learner("run")
    first.expect_event("started")
    first.kill()
    again = stage.learner("run")
    assert again.wait(30) == 2, again
    assert "--resume" in again.text, again


def test_resuming_what_does_not_exist_exits_2(stage):
    learner = stage.learner("nothing", "--resume")
    assert learner.wait(30) == 2, learner
    assert not (stage.runs / "nothing").exists()


@pytest.mark.parametrize(
    "command",
    [
        (ACTOR, "run"),
        (ACTOR, "run", "--run", "run", "--envs", "0"),
        (ACTOR, "run", "--run", "run", "--network", "::1"),
        (LEARNER, "status", "run", "--network", "[::1]"),
        (ACTOR, "trace", "--task", "push", "--recording", "/nowhere.csv", "--mode", "loose"),
        (ACTOR, "placements", "--task", "pussh", "--mode", "random", "--seed", "1"),
        (ACTOR, "evaluate"),
        (ACTOR, "dance"),
        (LEARNER, "inspect"),
        (LEARNER,),
    ],
    ids=lambda command: " ".join(word.split("/")[-1] for word in command),
)
def test_other_usage_errors_exit_2(stage, command):
    process = stage.start(*command)
    assert process.wait(30) == 2, process
    assert process.text, process


@pytest.mark.parametrize(
    "command",
    [
        (ACTOR, "evaluate", "--checkpoint", "/nowhere.ckpt"),
        (LEARNER, "inspect", "/nowhere.ckpt"),
        (ACTOR, "trace", "--task", "push", "--recording", "/nowhere.csv", "--mode", "free"),
    ],
    ids=lambda command: command[1],
)
def test_missing_files_are_named(stage, command):
    process = stage.start(*command)
    assert process.wait(30) != 0, process
    assert "/nowhere." in process.text, process


def test_a_folder_of_runs_that_cannot_be_made_is_named_with_the_way_out(stage, tmp_path):
    (tmp_path / "file").touch()
    learner = stage.learner("run", runs=tmp_path / "file" / "runs")
    assert learner.wait(30) == 1, learner
    assert f"cannot make {tmp_path}/file/runs/run (--runs DIR" in learner.text, learner


@pytest.mark.parametrize("program", [LEARNER, ACTOR], ids=["learner", "actor"])
def test_help_is_there_for_every_command(stage, program):
    overview = stage.start(program, "--help")
    assert overview.wait(30) == 0, overview
    commands = (
        ("run", "inspect", "export") if program == LEARNER else ("run", "trace", "placements", "evaluate")
    )
    for command in commands:
        assert command in overview.text, overview
        assert stage.start(program, command, "--help").wait(30) == 0


@pytest.mark.skipif(
    namespaces.mounts_unavailable() is not None, reason=str(namespaces.mounts_unavailable())
)
def test_a_name_with_ipv6_addresses_alone_is_said_to_have_them(stage, tmp_path):
    hosts = tmp_path / "hosts"
    hosts.write_text("2001:db8::7 node-7\n", encoding="utf-8")
    with contextlib.closing(namespaces.Mounts(f"mount --bind {hosts} /etc/hosts")) as machine:
        for options in (
            ("--network", "node-7"),
            ("--network", "lan", "--discovery-server", "node-7"),
        ):
            for process in (
                stage.learner("run", *options, host=machine),
                stage.actor("run", *options, host=machine),
                stage.status("run", *options, host=machine),
            ):
                assert process.wait(30) == 2, process
                assert "node-7': that host has IPv6 addresses alone" in process.text, process
