"""Standard output that nobody reads or that takes nothing, and signals that were ignored at the start: the work
goes on, of deploy/train and of all the programs beside it."""

import csv
import fcntl
import os
import pty
import select
import shlex
import shutil
import signal
import socket
import subprocess
from pathlib import Path

import pytest

import terminal
from harness import BUILD, ENDLESS, LEARNER, LONG, LONG_UPDATES, ROOT, SMALL, UPDATES
from unread import start_unread

TRAIN = ROOT / "deploy" / "train"


def words(stage, *options, small=SMALL, run="run", build=BUILD):
    """A command line of deploy/train."""
    line = [TRAIN, *small[1:], "--build", Path(build).absolute(), "--runs", stage.runs, "--run", run,
            "--domain", stage.domain, "--actors", 1, *options]
    return [str(word) for word in line]


def in_shell(stage, script, *command):
    """Starts bash with `script`, where "$@" is `command`."""
    return stage.start("bash", "-c", script, "bash", *command)


def version(stage):
    return stage.inspect(stage.latest("run"))["version"]


# Signals.


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT, signal.SIGTERM])
@pytest.mark.slow
def test_a_signal_that_was_ignored_at_the_start_does_not_stop_a_run(stage, number):
    launcher = stage.start("env", f"--ignore-signal={number.name[3:]}", *words(stage, small=LONG))
    launcher.expect_text("update    1/")
    launcher.signal(number)
    assert launcher.wait() == 0, launcher
    assert version(stage) == LONG_UPDATES


def test_where_sigint_was_ignored_another_signal_still_stops_with_a_checkpoint(stage):
    launcher = stage.start("env", "--ignore-signal=INT", *words(stage, small=ENDLESS))
    launcher.expect_text("update    1/")
    launcher.signal(signal.SIGTERM)
    assert launcher.wait(50) == 128 + signal.SIGTERM, launcher
    assert "stopped after update" in launcher.text, launcher


def test_where_the_end_of_children_was_ignored_their_exit_codes_count(stage, tmp_path):
    made = stage.start("env", "--ignore-signal=CHLD", ROOT / "deploy" / "exchange", tmp_path / "none.ckpt", "--out",
                       tmp_path / "out", "--build", BUILD)
    assert made.wait(30) == 1 and "none.ckpt" in made.text and "Traceback" not in made.text, made


# Output.


@pytest.mark.parametrize("script", [
    '"$@" | head -n 1; exit ${PIPESTATUS[0]}',
    '"$@" 2>&1 | true; exit ${PIPESTATUS[0]}',
    'exec "$@" >/dev/full 2>&1',
    'exec "$@" <&- >&- 2>&-',
    'mkdir aside; cd aside; rmdir ../aside; exec "$@"',
], ids=["a reader that left", "no reader", "a full disk", "closed", "a removed folder"])
@pytest.mark.slow
def test_what_cannot_be_shown_stops_no_run(stage, tmp_path, script):
    launcher = in_shell(stage, f"cd {tmp_path}; {script}", *words(stage))
    assert launcher.wait() == 0, launcher
    assert version(stage) == UPDATES


@pytest.mark.slow
def test_output_that_nobody_reads_stops_no_run(stage, unread):
    launcher = start_unread(stage, unread, words(stage))
    assert launcher.wait(100) == 0
    assert version(stage) == UPDATES


@pytest.mark.parametrize("program", ["train", "experiment", "exchange", "security"])
@pytest.mark.slow
def test_a_usage_error_that_nobody_reads_ends_with_2(stage, unread, program):
    assert start_unread(stage, unread, [ROOT / "deploy" / program, "--bogus"]).wait(60) == 2


@pytest.mark.slow
def test_ctrl_c_is_served_while_nobody_reads(stage, unread):
    launcher = start_unread(stage, unread, words(stage, small=ENDLESS))
    stage.status("run", "--follow", "--wait", 60).expect(lambda line: '"version":' in line, "the run's state")
    launcher.send_signal(signal.SIGINT)
    assert launcher.wait(50) == 128 + signal.SIGINT
    assert stage.latest("run").exists()


# Runs its arguments in the background of a terminal, the first one, that stops whoever writes to it from there.
BEHIND = """
import os, subprocess, sys, termios
fd = os.open(sys.argv[1], os.O_RDWR)
mode = termios.tcgetattr(fd)
mode[3] |= termios.TOSTOP
termios.tcsetattr(fd, termios.TCSANOW, mode)
sys.exit(subprocess.run(sys.argv[2:], stdout=fd, stderr=fd, process_group=0).returncode)
"""


def test_a_terminal_that_stops_background_writers_stops_no_run(stage):
    master, slave = pty.openpty()
    launcher = stage.start("/usr/bin/python3", "-c", BEHIND, os.ttyname(slave), *words(stage))
    assert launcher.wait(60) == 0, launcher
    assert version(stage) == UPDATES
    os.close(slave)
    os.close(master)


@pytest.mark.slow
def test_an_experiment_goes_on_unread_and_unstoppable_by_what_was_ignored(stage, unread, tmp_path):
    file = tmp_path / "e.toml"
    engine = "3.3.0" if BUILD.name.endswith("3.3.0") else "2.2.2"
    file.write_text(f'\ufeffname = "small"\nmujoco = "{engine}"\ntasks = ["push"]\nseeds = [7]\nsteps = 1600\n'
                    'milestones = 1\n[evaluate]\nepisodes = 1\n[set]\n"environment.horizon" = 50\n'
                    '"collection.episodes_per_update" = 4\n"ppo.minibatch" = 50\n[arms.ppo]\nmethod = "ppo"\n')
    command = ["env", "--ignore-signal=HUP", ROOT / "deploy" / "experiment", file, "--build", BUILD, "--jobs", 1,
               "--runs", stage.runs, "--results", tmp_path / "results", "--domain", stage.domain]
    experiment = start_unread(stage, unread, command)
    # The cell's name is that of the run.
    stage.status("push-ppo-s7", "--wait", 60).expect(lambda line: '"version":' in line, "the run's state")
    experiment.send_signal(signal.SIGHUP)
    assert experiment.wait(100) == 0
    assert "push-ppo-s7" in (tmp_path / "results" / "small" / "runs.jsonl").read_text()


@pytest.mark.slow
def test_exchanges_go_on_unread_and_a_row_is_written_whole_or_not_at_all(stage, unread, tmp_path):
    stage.train("two", "--heads", "2")
    command = [ROOT / "deploy" / "exchange", stage.latest("two"), "--out", tmp_path / "out", "--episodes", 1,
               "--build", BUILD]
    limited = stage.start("prlimit", "--fsize=300", *command)
    assert limited.wait() == 1, limited
    with open(tmp_path / "out" / "latest.csv", newline="") as file:
        assert [row["order"] for row in csv.DictReader(file)] == ["0,1"]
    assert start_unread(stage, unread, command).wait(100) == 0
    with open(tmp_path / "out" / "latest.csv", newline="") as file:
        assert [row["order"] for row in csv.DictReader(file)] == ["0,1", "1,1", "0,0"]


@pytest.mark.slow
def test_identities_are_made_unread(stage, unread, tmp_path):
    command = [ROOT / "deploy" / "security", tmp_path / "made", "--run", "run", "--actors", 1]
    assert start_unread(stage, unread, command).wait(60) == 0
    assert (tmp_path / "made" / "actor-0" / "cert.pem").exists()


# Set-up.


@pytest.fixture
def checkout(tmp_path):
    """A copy of deploy/setup that needs nothing and builds one thing: it writes to `begun`, then reads `go`."""
    for name in ("deploy/setup", "deploy/checkout.sh", "deploy/metaworld.txt", "CMakePresets.json",
                 "common/compile_options.cmake"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / ".cache").mkdir()
    (tmp_path / ".cache" / "metaworld-3.1.1").symlink_to(ROOT / ".cache" / "metaworld-3.1.1")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "CMakeCache.txt").write_text("METRONOME_MARCH:STRING=x86-64-v3\n")
    (tmp_path / "build" / "build.ninja").write_text(
        "rule wait\n  command = echo begun >begun; read line <go; touch $out\nbuild programs: wait\n")
    for name in ("begun", "go"):
        os.mkfifo(tmp_path / "build" / name)
    return tmp_path


@pytest.mark.parametrize("script", ['exec "$@"', 'exec "$@" >/dev/full 2>&1', 'exec "$@" >&- 2>&-', '"$@" 2>&1 | true'],
                         ids=["shown", "a full disk", "closed", "no reader"])
@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT])
def test_a_build_goes_on_unread_and_under_signals_that_were_ignored(stage, checkout, script, number):
    begun, go = (os.open(checkout / "build" / name, os.O_RDWR) for name in ("begun", "go"))
    setup = in_shell(stage, f"trap '' {number.name[3:]}; set -o pipefail; {script}", checkout / "deploy" / "setup")
    assert select.select([begun], [], [], 30)[0], setup
    os.killpg(setup.child.pid, number)
    os.write(go, b"\n")
    assert setup.wait(30) == 0, setup
    os.close(begun)
    os.close(go)
    assert (checkout / "build" / "programs").exists()
    # What showed the build has ended, too, and lets the next set-up in.
    assert stage.start("flock", "--timeout", "30", checkout / ".cache" / "setup.lock", "true").wait() == 0


# Trouble of the launcher's own.


def learner_that(stage, does):
    """A build whose learner is a bash script: `does`, where $LEARNER is the real one."""
    build = stage.runs.parent / "build"
    (build / "bin").mkdir(parents=True)
    (build / "bin" / "metronome-actor").symlink_to((BUILD / "bin" / "metronome-actor").absolute())
    learner = build / "bin" / "metronome-learner"
    learner.write_text(f"#!/bin/bash\nLEARNER={shlex.quote(os.path.abspath(LEARNER))}\n{does}\n")
    learner.chmod(0o755)
    return build


def test_a_fault_of_the_launcher_ends_the_run_with_a_checkpoint(stage):
    # Of the second line on, updates are not as they should be; more comes than a pipe holds.
    does = """exec > >(sed -u '2,$s/"return"/"retorn"/'); exec "$LEARNER" "$@" """
    launcher = stage.start(*words(stage, "--set", "runtime.checkpoint_every=1000000", small=ENDLESS,
                                  build=learner_that(stage, does)))
    assert launcher.wait(90) == 1, launcher
    assert "KeyError: 'return'" in launcher.text and "--resume" in launcher.text, launcher
    assert version(stage) > 0


def test_a_killed_launcher_leaves_a_checkpoint(stage):
    launcher = stage.start(*words(stage, "--set", "runtime.checkpoint_every=1000000", small=ENDLESS))
    launcher.expect_text("update    1/")
    launcher.kill()
    # Holds the run's folder until the learner has ended.
    again = stage.start("flock", stage.runs / "run" / "lock", "true")
    assert again.wait(60) == 0
    assert version(stage) > 0


@pytest.mark.slow
def test_logs_that_cannot_be_written_stop_no_run(stage):
    (stage.runs / "run").mkdir(parents=True)
    (stage.runs / "run" / "logs").touch()
    launcher = stage.start(*words(stage))
    assert launcher.wait() == 0, launcher
    assert version(stage) == UPDATES


@pytest.mark.slow
def test_a_learner_that_does_not_begin_is_told_of_with_its_words(stage):
    build = learner_that(stage, "echo 'lost in thought' >&2; exec sleep 1000")
    launcher = stage.start(*words(stage, build=build))
    launcher.expect_text("the learner does not serve the run after 10 s; it says:", 40)
    launcher.expect_text("  lost in thought")
    launcher.signal(signal.SIGTERM)
    assert launcher.wait(30) == 128 + signal.SIGTERM


@pytest.mark.slow
def test_that_no_actor_has_joined_is_told_with_the_place_to_look(stage):
    build = learner_that(stage, 'exec "$LEARNER" "$@"')
    (build / "bin" / "metronome-actor").unlink()
    (build / "bin" / "metronome-actor").write_text("#!/bin/sh\necho 'I see nobody' >&2\nexec sleep 1000\n")
    (build / "bin" / "metronome-actor").chmod(0o755)
    launcher = stage.start(*words(stage, build=build))
    said = launcher.expect_text("no actor has joined after 10 s", 60)
    assert "learner.log" in said and "actor-*.log" in said and "firewalls" in said
    launcher.expect_text("  I see nobody")
    launcher.signal(signal.SIGINT)
    assert launcher.wait(50) == 128 + signal.SIGINT


# Outlets by themselves.


@pytest.fixture
def pipe():
    read, write = os.pipe()
    yield read, write
    os.close(read)
    os.close(write)


def refuse_to_open(*_):
    raise PermissionError


@pytest.mark.parametrize("may_open", [True, False], ids=["opened anew", "asked first"])
def test_an_outlet_gives_up_the_oldest_and_leaves_the_pipe_as_others_know_it(pipe, may_open, monkeypatch):
    read, write = pipe
    with monkeypatch.context() as patch:
        if not may_open:  # as of another user
            patch.setattr(os, "open", refuse_to_open)
        outlet = terminal.Outlet(write, "utf-8")
    for number in range(20_000):
        outlet.write(f"line {number}\n")
    assert outlet.waiting and fcntl.fcntl(write, fcntl.F_GETFL) & os.O_NONBLOCK == 0
    outlet.drain(0.0)
    text = b""
    while outlet.waiting:
        text += os.read(read, 65536)
        outlet.flush()
    text += os.read(read, 65536)
    numbers = [int(line.split()[1]) for line in text.decode().splitlines()]
    assert numbers[0] == 0 and numbers[-1] == 19_999 and numbers == sorted(numbers) and len(numbers) < 20_000


def test_an_outlet_of_a_terminal_of_another_user_never_blocks(monkeypatch):
    master, slave = pty.openpty()
    with monkeypatch.context() as patch:
        patch.setattr(os, "open", refuse_to_open)
        outlet = terminal.Outlet(slave, "utf-8")
    for _ in range(1000):  # more than the kernel keeps of what nobody reads
        outlet.write("x" * 99 + "\n")
    assert outlet.isatty() and outlet.waiting
    os.close(master)
    os.close(slave)


def test_an_outlet_of_a_socket_never_blocks():
    ours, theirs = socket.socketpair()
    outlet = terminal.Outlet(ours.fileno(), "utf-8")
    while not outlet.waiting:
        outlet.write("x" * 4096 + "\n")
    theirs.close()
    outlet.write("more\n")
    assert not outlet.waiting
    ours.close()


def test_an_outlet_writes_names_as_they_are_on_disk_and_what_its_encoding_lacks_as_escapes(pipe):
    outlet = terminal.Outlet(pipe[1], "ascii")
    print(os.fsdecode(b"runs-\xff"), "caf\u00e9", file=outlet)
    assert os.read(pipe[0], 100) == b"runs-\xff caf\\xe9\n"


@pytest.mark.parametrize("environment", [{"LC_ALL": "C"}, {"PYTHONIOENCODING": "ascii"}], ids=["LC_ALL=C", "ascii"])
def test_a_folder_that_is_not_utf_8_can_be_told_of(tmp_path, environment):
    folder = os.path.join(os.fsencode(tmp_path), b"runs \xff")
    os.mkdir(folder)
    done = subprocess.run([TRAIN, "--runs", folder, "--run", "a", "--resume"], capture_output=True,
                          env=os.environ | environment)
    assert done.returncode == 2 and b"Traceback" not in done.stderr
    assert b"no run a in " + folder in done.stderr
