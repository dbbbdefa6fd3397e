"""One run as one job of a real Slurm: two nodes, which are two slurmd of this machine. What its tasks are started
with is tested without Slurm, too."""

import getpass
import json
import os
import shutil
import socket
import subprocess
import time

import pytest

import children
from harness import BUILD, DEADLINE, EPISODES, HORIZON, ROOT, SMALL, small

PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch", "srun", "scontrol")
missing = [name for name in PROGRAMS if not shutil.which(name, path="/usr/sbin:/usr/bin")]
CONFIG = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldPort={ports[0]}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=4
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=4
PartitionName=all Nodes=n1,n2 Default=YES State=UP
"""


def wait_until(true, what, seconds=DEADLINE):
    """Other processes' files and states have no event to wait for."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, f"after {seconds} s not: {what()}"
        time.sleep(0.1)


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Cluster:
    def __init__(self, folder):
        self.folder = folder
        folder.chmod(0o755)
        for name in ("state", "n1", "n2"):
            (folder / name).mkdir()
        (folder / "key").write_bytes(os.urandom(128))
        (folder / "key").chmod(0o600)
        config = folder / "slurm.conf"
        config.write_text(
            CONFIG.format(
                host=socket.gethostname().split(".")[0],
                user=getpass.getuser(),
                folder=folder,
                ports=free_ports(3),
            )
        )
        self.environment = dict(
            os.environ, SLURM_CONF=str(config), PATH=f"/usr/sbin:{os.environ['PATH']}"
        )
        files = {"socket": "munge", "key-file": "key", "pid-file": "pid", "seed-file": "seed"}
        munge = [f"--{option}={folder / name}" for option, name in files.items()]
        self.daemons = [self.start("munged", "--foreground", "--force", *munge)]
        wait_until((folder / "munge").exists, lambda: self.log("munged"))
        self.daemons.append(self.start("slurmctld", "-D"))
        self.daemons += [self.start("slurmd", "-D", "-N", node) for node in ("n1", "n2")]
        wait_until(
            lambda: self.ask("sinfo", "-h", "-o", "%T %D", check=False) == "idle 2",
            lambda: self.log("slurmctld"),
        )

    def start(self, *command):
        with open(self.folder / f"{command[0]}.log", "ab") as log:
            return children.start(
                list(command), stdout=log, stderr=log, env=self.environment, cwd=self.folder
            )

    def log(self, name):
        return (self.folder / f"{name}.log").read_text(errors="replace")[-2000:]

    def ask(self, *command, check=True, **variables):
        return subprocess.run(
            [str(word) for word in command],
            env=self.environment | variables,
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=check,
            timeout=DEADLINE,
        ).stdout.strip()

    def submit(self, runs, name, *options):
        self.job_log = self.folder / f"{name}.log"
        command = ["sbatch", "--parsable", "--nodes=2", "--ntasks=3", f"--output={self.job_log}"]
        command += ["deploy/slurm/metronome.sbatch", name, *options]
        # The nodes' names are invented, so the learner's host is named.
        return self.ask(*command, RUNS=str(runs), LEARNER_HOST="localhost")

    def state(self, job):
        return self.ask("scontrol", "show", "job", job).split("JobState=")[1].split()[0]

    def finish(self, job):
        ends = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")
        wait_until(lambda: self.state(job) in ends, lambda: self.state(job) + self.words())
        assert self.state(job) == "COMPLETED", self.words()

    def words(self):
        return self.job_log.read_text() if self.job_log.exists() else "(the job said nothing)"

    def close(self):
        self.ask("scancel", "--user", getpass.getuser(), check=False)
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            daemon.wait(DEADLINE)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    cluster = Cluster(tmp_path_factory.mktemp("slurm"))
    yield cluster
    cluster.close()


def needs_slurm(test):
    for mark in (
        pytest.mark.skipif(bool(missing), reason="not installed (slurm-wlm, munge): " + " ".join(missing)),
        pytest.mark.skipif(os.geteuid() != 0, reason="slurmd is root's"),
        pytest.mark.skipif(BUILD != ROOT / "build", reason="the job's programs are those of build/"),
    ):
        test = mark(test)
    return test


@needs_slurm
def test_a_job_on_two_nodes_gives_the_weights_of_a_run_without_slurm(stage, cluster):
    expected = stage.train("calm")
    cluster.finish(cluster.submit(stage.runs, "job", *SMALL))
    assert stage.inspect(stage.latest("job"))["weights_sha256"] == expected


@needs_slurm
def test_a_job_whose_time_is_nearly_up_is_requeued_and_goes_on(stage, cluster):
    longer = small(100 * EPISODES * HORIZON)
    job = cluster.submit(stage.runs, "job", *longer)
    latest = stage.latest("job")
    wait_until(lambda: latest.exists() and latest.resolve().name > "000000.ckpt", cluster.words)
    cluster.ask("scancel", "--batch", "--signal=USR1", job)
    wait_until(lambda: cluster.state(job) == "PENDING", cluster.words)
    assert 0 < stage.inspect(stage.latest("job"))["version"] < 100, "it was not under way"
    # Slurm lets a requeued job wait for two minutes; sooner than two seconds its credential is the old one.
    cluster.ask("scontrol", "update", f"JobId={job}", "StartTime=now+5seconds")
    cluster.finish(job)

    learner, actor = stage.learner("calm", small=longer), stage.actor("calm")
    assert (learner.wait(), actor.wait()) == (0, 0), learner
    job_end, calm_end = (stage.inspect(stage.latest(name)) for name in ("job", "calm"))
    assert job_end["incarnation"] == 2
    assert job_end["weights_sha256"] == calm_end["weights_sha256"]


# srun, as far as the job needs it: takes its options, then runs the words that follow as each task.
SRUN = """#!/usr/bin/python3
import os, subprocess, sys
words = sys.argv[1:]
while words[0].startswith("--"):
    words.pop(0)
for task in range(int(os.environ["SLURM_NTASKS"])):
    subprocess.run(words, env={**os.environ, "SLURM_PROCID": str(task)}, check=True)
"""
# A program that notes what it was called with.
PROGRAM = """#!/usr/bin/python3
import json, os, sys
with open(f"said-{os.environ['SLURM_PROCID']}", "w") as file:
    json.dump(sys.argv, file)
"""
ODD_WORDS = ["", "two  words", "it's", 'a "b"', "back\\slash", "two\nlines", "%t", "*", "$HOME", "`id`", "#", "~", "\\'"]


def executable(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


@pytest.fixture
def submit(tmp_path):
    """Runs the job's script on words as sbatch does, in a checkout whose programs note theirs. @return them by task."""
    checkout = tmp_path / "check out"
    for program in ("metronome-learner", "metronome-actor"):
        executable(checkout / "build" / "bin" / program, PROGRAM)
    executable(tmp_path / "bin" / "srun", SRUN)
    executable(tmp_path / "bin" / "scontrol", "#!/bin/sh\nexec seq -f node%.0f 7 9999\n")
    (checkout / "deploy").symlink_to(ROOT / "deploy")

    def run(*words, status=0, **environment):
        done = subprocess.run(
            ["bash", ROOT / "deploy" / "slurm" / "metronome.sbatch", *words],
            cwd=checkout, timeout=DEADLINE, capture_output=True, text=True,
            env={"PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}", "METRONOME_BIN": str(checkout / "build" / "bin"),
                 "SLURM_NTASKS": "3", "SLURM_JOB_ID": "41", "SLURM_JOB_NODELIST": "node[7-8]", **environment})
        assert done.returncode == status, done.stderr
        return done.stderr if status else [json.loads((checkout / f"said-{task}").read_text()) for task in range(3)]

    return run


@pytest.mark.parametrize("options", [[], ["--task", "push"], ODD_WORDS], ids=["none", "some", "odd"])
def test_a_jobs_options_reach_the_learner_word_by_word(submit, options):
    learner, *actors = submit("job", *options)
    assert learner[1:] == ["run", "--runs", "runs", "--run", "job", "--domain", "42", "--network", "lan", *options]
    for actor in actors:
        assert actor[1:] == ["run", "--run", "job", "--domain", "42", "--network", "node7", "--envs", "1"]


@pytest.mark.parametrize("odd", ["two  words", "it's", "back\\slash"])
def test_a_jobs_folder_of_runs_may_have_any_name(submit, odd):
    learner, actor, _ = submit("job", RUNS=odd, LEARNER_HOST="a host", SLURM_CPUS_PER_TASK="4")
    assert learner[1:4] == ["run", "--runs", odd]
    assert actor[-4:] == ["--network", "a host", "--envs", "4"]


@pytest.mark.parametrize("tasks", ["", "1"], ids=["not named", "one"])
def test_a_job_of_too_few_tasks_says_what_to_ask_for(submit, tasks):
    """Without --ntasks, Slurm names no number."""
    assert "--ntasks" in submit("job", status=2, SLURM_NTASKS=tasks)
