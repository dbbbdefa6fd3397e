"""deploy/train: one command for learner and actors."""

import os
import re
import select
import shlex
import signal

import pytest

import children
import session
from harness import BUILD, ENDLESS, LONG, LONG_UPDATES, ROOT, SMALL, STEPS

TRAIN = str(ROOT / "deploy" / "train")


def train(stage, *options, actors=2, small=SMALL):
    """@param options  take the place of those that are given here."""
    usual = {"--build": BUILD, "--runs": stage.runs, "--domain": stage.domain, "--actors": actors}
    given = [word for name, value in usual.items() if name not in options for word in (name, value)]
    return stage.start(TRAIN, *small[1:], *given, *options)  # the task without its option's name


def runs_of(stage):
    """Process ids and command lines of the learner and actors of this test's run `run`."""
    found, domain = [], str(stage.domain)
    for entry in os.listdir("/proc"):
        try:
            with open(f"/proc/{entry}/cmdline", "rb") as file:
                words = file.read().decode(errors="replace").split("\0")
        except OSError:
            continue
        options = set(zip(words, words[1:]))
        if "metronome-" in words[0] and {("--run", "run"), ("--domain", domain)} <= options:
            found.append((entry, words))
    return found


def test_it_trains_to_the_end_and_says_where_the_results_are(stage):
    launcher = train(stage, "--run", "run")
    assert launcher.wait() == 0, launcher
    assert "every episode number entered exactly one update: 32 of 32" in launcher.text, launcher
    assert "learner and 2 actors; logs in" in launcher.text, launcher
    assert re.search(r"update +8/8 +1600/1600 steps +return .* success .* steps/s", launcher.text)
    # The words by which the launcher knows that an actor is there.
    assert session.JOINED.search((stage.runs / "run" / "logs" / "learner.log").read_bytes())
    for word in ("progress.csv", "checkpoints/latest", "evaluate --checkpoint"):
        assert word in launcher.text, launcher
    assert not runs_of(stage)
    assert stage.inspect(stage.latest("run"))["steps"] == STEPS


def test_a_run_of_one_placement_is_evaluated_on_it(stage):
    launcher = train(stage, "--run", "run", "--placements", "fixed")
    assert launcher.wait() == 0, launcher
    assert "/checkpoints/latest --placements fixed\n" in launcher.text + "\n", launcher


@pytest.mark.parametrize("name", ["train", "experiment", "exchange", "security"])
def test_python_settings_of_others_do_not_matter(stage, tmp_path, name):
    (tmp_path / "json.py").write_text("raise ImportError('not this one')")
    command = ("env", "PYTHONHOME=/nowhere", f"PYTHONPATH={tmp_path}", ROOT / "deploy" / name, "--help")
    assert stage.start(*command).wait(60) == 0


@pytest.mark.slow
def test_the_default_name_is_new_each_time(stage):
    for _ in range(2):
        launcher = train(stage)
        assert launcher.wait() == 0, launcher
    assert len(list(stage.runs.iterdir())) == 2


def test_an_existing_run_needs_resume(stage):
    (stage.runs / "run" / "checkpoints").mkdir(parents=True)
    launcher = train(stage, "--run", "run")
    assert launcher.wait(30) == 2, launcher
    assert "--resume" in launcher.text, launcher


@pytest.mark.slow
def test_resuming_what_is_finished_starts_no_actor(stage):
    launcher = train(stage, "--run", "run")
    assert launcher.wait() == 0, launcher
    log = stage.runs / "run" / "logs" / "actor-0.log"
    said = log.read_text()
    again = train(stage, "--run", "run", "--resume")
    assert again.wait() == 0, again
    assert "finished: " in again.text and "learner and 0 actors" in again.text, again
    assert log.read_text() == said


@pytest.mark.slow
def test_no_more_actors_start_than_can_have_something_to_play(stage):
    cores = len(os.sched_getaffinity(0))
    if cores < 2:
        pytest.skip("one core has one actor")
    few = [None, *SMALL[1:], "--set", "collection.episodes_per_update=1", "--set", "ppo.minibatch=50"]
    launcher = stage.start(TRAIN, *few[1:], "--run", "run", "--build", BUILD, "--runs", stage.runs, "--domain", stage.domain)
    assert launcher.wait() == 0, launcher
    assert "learner and 1 actor; logs in" in launcher.text, launcher
    assert launcher.text.count("warning: ") == 1, launcher
    command = shlex.split(launcher.lines[launcher.lines.index(launcher.expect_text("warning: ")) + 1])
    assert command[-3].endswith("deploy/wide.textproto"), command
    assert command[-1] == f"collection.episodes_per_update={2 * cores}", command
    asked = train(stage, "--run", "asked", actors=2, small=few)
    assert asked.wait() == 0 and "learner and 2 actors" in asked.text, asked
    assert asked.text.count("are often idle") == 1, asked


def test_resuming_what_does_not_exist_exits_2(stage):
    launcher = train(stage, "--run", "nothing", "--resume")
    assert launcher.wait(30) == 2, launcher


def test_what_a_killed_start_leaves_is_no_run_yet(stage):
    (stage.runs / "run").mkdir(parents=True)
    for name in ("lock", "incarnation"):
        (stage.runs / "run" / name).write_text("1\n")
    refused = train(stage, "--run", "run", "--resume")
    assert refused.wait(30) == 2, refused
    assert "there is no run run in" in refused.text and "did you mean" not in refused.text, refused
    again = train(stage, "--run", "run")
    assert again.wait() == 0, again


@pytest.mark.parametrize(
    "options",
    [
        ("--heads", "51"),
        ("--set", "ppo.clipp=1"),
        ("--method", "pppo"),
        ("--actors", "-1"),
        ("--bogus",),
    ],
    ids=lambda options: options[0],
)
def test_usage_errors_exit_2_and_leave_nothing(stage, options):
    launcher = train(stage, "--run", "run", *options)
    assert launcher.wait(60) == 2, launcher
    assert not (stage.runs / "run").exists()


def test_the_learners_options_are_the_learners_alone(stage):
    launcher = train(stage, "--threads", "1", "--run", "run", "--checkpoint-every=8", "--set", "ppo.clip=0.25")
    assert launcher.wait() == 0, launcher
    config = (stage.runs / "run" / "config.textproto").read_text()
    for line in ("learner_threads: 1", "checkpoint_every: 8", "clip: 0.25"):
        assert line in config, config


def test_the_instructions_that_are_chosen_are_the_learners_and_its_actors(stage):
    launcher = train(stage, "--run", "run", "--isa", "scalar", actors=1)
    assert launcher.wait() == 0, launcher
    assert stage.inspect(stage.latest("run"))["isa"] == "scalar"
    assert re.search(r"joins with .* isa scalar\n", (stage.runs / "run" / "logs" / "learner.log").read_text())


@pytest.mark.parametrize("options, says", [
    (("--chekpoint-every", 8), '"--chekpoint-every"; did you mean "--checkpoint-every"?'),
    (("--heads",), "--heads"),
    (("--heads", "-5"), "--heads: policy.heads is -5"),
    (("--isa", "avx"), '--isa: unknown instruction set "avx"; did you mean "avx2"?'),
    (("--progress", "lines"), "--progress is set by deploy/train itself"),
    (("more",), "unexpected argument 'more'"),
    (("--runs-dir", "runs"), "--runs-dir is set by deploy/train itself; give --runs"),
    (("--envs", "1", "--envs", "2"), "--envs is given twice, and it has one value: 1 or 2?"),
    (("--heads", "3", "--heads", "4"), '--heads is given 2 times, and it has one value: "3" or "4"?'),
    (("--config", "no-such-file", "--config", "/dev/null"), "--config: no-such-file: No such file or directory"),
], ids=lambda value: value[0] if isinstance(value, tuple) else "")
def test_options_that_nobody_knows_are_named_and_leave_nothing(stage, options, says):
    launcher = train(stage, "--run", "run", *options)
    assert launcher.wait(60) == 2, launcher
    assert says in launcher.text, launcher
    assert not (stage.runs / "run").exists()


def test_configuration_files_are_merged_in_order(stage, tmp_path):
    first, second = tmp_path / "first.textproto", tmp_path / "second.textproto"
    first.write_text('environment { task: "push" }\nseed: 3\nppo { clip: 0.3 discount: 0.9 }\n')
    second.write_text("seed: 4\nppo { clip: 0.1 }\n")
    files = ("--config", first, "--config", second)
    no_seed = [None, *SMALL[2:4], *SMALL[6:]]  # nor a task
    launcher = train(stage, "--run", "run", *files, small=no_seed)
    assert launcher.wait() == 0, launcher
    config = (stage.runs / "run" / "config.textproto").read_text()
    for line in ("seed: 4", "clip: 0.1", "discount: 0.9"):
        assert line in config, config
    second.write_text("ppo { clip: -1 }\n")
    wrong = train(stage, "--run", "wrong", *files, small=no_seed)
    assert wrong.wait(60) == 2 and f"{second}:1:7: ppo.clip is -1" in wrong.text, wrong


def test_a_task_may_stand_behind_the_learners_options(stage):
    launcher = train(stage, small=[None, "--threads", "1", "--new-total", "push", "--run", "run", *SMALL[2:]])
    assert launcher.wait(60) == 2, launcher
    assert "--new-total is for --resume" in launcher.text, launcher  # so push was no value of it


def test_help_lists_the_learners_options_too(stage):
    launcher = stage.start(TRAIN, "--build", BUILD, "--help")
    assert launcher.wait(30) == 0, launcher
    for option in ("--actors", "--threads", "--checkpoint-every", "--set"):
        assert re.search(rf"^ +{option} ", launcher.text, re.M), launcher


@pytest.mark.parametrize("option", ["--config", "--from", "--build", "--security", "--runs"])
def test_a_name_that_is_too_long_is_named(stage, option):
    launcher = train(stage, "--run", "run", option, "x" * 300)
    assert launcher.wait(60) != 0, launcher
    assert "x" * 300 in launcher.text and "Traceback" not in launcher.text, launcher


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.slow
def test_stopping_leaves_a_checkpoint_and_no_orphans_and_resume_goes_on(stage, number):
    launcher = train(stage, "--run", "run", small=LONG)
    launcher.expect_text("update    1/")
    launcher.signal(number)
    assert launcher.wait(90) == 128 + number, launcher
    assert not runs_of(stage)
    assert stage.latest("run").exists()
    assert "--resume" in launcher.text, launcher
    again = train(stage, "--run", "run", "--resume", small=LONG)
    assert again.wait() == 0, again
    assert stage.inspect(stage.latest("run"))["version"] == LONG_UPDATES


def test_stopping_a_run_that_cannot_leave_a_checkpoint_is_a_failure(stage):
    launcher = train(stage, "--run", "run", small=ENDLESS)
    launcher.expect_text("update    1/")
    # As a full disk does, no file can be made in the folder.
    folder = stage.runs / "run" / "checkpoints"
    folder.rename(stage.runs / "run" / "aside")
    folder.touch()
    launcher.expect_text("NOT WRITTEN")  # so there is an update that no checkpoint holds
    launcher.signal(signal.SIGINT)
    assert launcher.wait(90) == 1, launcher
    assert "the learner ended with" in launcher.text and "NOT WRITTEN" in launcher.text, launcher


def test_a_killed_launcher_leaves_no_orphans(stage):
    launcher = train(stage, "--run", "run", small=ENDLESS)
    launcher.expect_text("update    1/")
    started = [os.pidfd_open(int(pid)) for pid, _ in runs_of(stage)]
    assert started
    launcher.kill()
    for child in started:
        assert select.select([child], [], [], 30)[0], "a child outlived its launcher"
        os.close(child)


@pytest.mark.slow
def test_a_killed_actor_is_started_again(stage):
    launcher = train(stage, "--run", "run", actors=1, small=LONG)
    launcher.expect_text("update    1/")
    actors = [int(pid) for pid, words in runs_of(stage) if words[0].endswith("metronome-actor")]
    os.kill(actors[0], signal.SIGKILL)
    assert launcher.wait() == 0, launcher
    assert "starting it again" in launcher.text, launcher


def test_without_actors_it_waits_for_others(stage):
    launcher = train(stage, "--run", "run", actors=0)
    said = launcher.expect_text("metronome-actor run")
    assert stage.start(*shlex.split(said.partition("start them with ")[2])).wait() == 0
    assert launcher.wait() == 0, launcher


def dangling(path):
    path.symlink_to("nowhere")


@pytest.mark.parametrize("make, says", [(dangling, "is a link to nowhere, which is not there"),
                                        (lambda path: path.touch(), "is not a folder")], ids=["dangling link", "file"])
@pytest.mark.parametrize("where", ["runs", "runs/run", "above/runs"])
def test_what_cannot_be_a_folder_is_named(stage, tmp_path, make, says, where):
    stage.runs = tmp_path / where.removesuffix("/run")
    wrong = tmp_path / where.removesuffix("/runs") if "above" in where else tmp_path / where
    wrong.parent.mkdir(exist_ok=True)
    make(wrong)
    launcher = train(stage, "--run", "run")
    assert launcher.wait(30) == 2, launcher
    assert f"{wrong} {says}" in launcher.text and "Traceback" not in launcher.text, launcher
    assert not os.path.exists(tmp_path / "nowhere")


def test_without_its_programs_a_build_is_refused(stage, tmp_path):
    launcher = train(stage, "--build", tmp_path)
    assert launcher.wait(30) == 2, launcher
    assert f"there is no {tmp_path}/bin/metronome-learner" in launcher.text, launcher


@pytest.mark.slow
def test_printed_commands_can_be_typed(stage, tmp_path):
    stage.runs = tmp_path / "my runs"
    launcher = train(stage, "--run", "run", small=ENDLESS)
    launcher.expect_text("update    1/")
    watch = next(line for line in launcher.lines if line.startswith("  watch "))
    status = stage.start(*shlex.split(watch)[1:])
    assert status.wait() == 0 and "run run " in status.text, status
    launcher.signal(signal.SIGINT)
    assert launcher.wait(50) == 128 + signal.SIGINT, launcher
    said = {line.split()[0]: shlex.split(line)[1:] for line in launcher.lines if line.startswith("  ")}
    assert launcher.text.count("stopped") == 1, launcher
    assert said["curves"] == ["tensorboard", "--logdir", str(stage.runs / "run")]
    assert said["evaluate"][-1] == str(stage.latest("run")), launcher
    evaluated = stage.start(*said["evaluate"], "--episodes", 1)
    assert evaluated.wait() == 0, evaluated
    again = stage.start(*said["go"][1:], "--set", "nothing.at_all=1")  # understood up to what is wrong
    assert again.wait() == 2 and 'unknown setting "nothing"' in again.text, again


@pytest.fixture
def events():
    before = {number: signal.getsignal(number) for number in (*children.STOP_SIGNALS, signal.SIGCHLD)}
    yield children.Events()
    signal.set_wakeup_fd(-1)
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_stop_that_comes_while_output_is_drained_is_told_of_later(events):
    read, write = os.pipe()
    lines = []
    events.watch(os.fdopen(read, "rb"), lines.append)
    os.write(write, b"last words\n")
    os.close(write)
    os.kill(os.getpid(), signal.SIGINT)
    events.drain()
    assert lines == [b"last words"]
    assert events.wait(0) == [signal.SIGINT]
    assert events.wait(0) == []
