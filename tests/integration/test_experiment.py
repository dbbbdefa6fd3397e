"""deploy/experiment: a matrix of runs, resumable at any instant."""

import errno
import importlib.util
import os
import select
import shlex
import shutil
import signal
import sys
from types import SimpleNamespace

import pytest

from harness import ACTOR, BUILD, DEADLINE, ENGINE, LEARNER, ROOT

sys.path.insert(0, str(ROOT / "deploy" / "experimenter"))
from cell_files import CellFiles  # noqa: E402
from result_files import ResultFiles, read_rows  # noqa: E402

EXPERIMENT = str(ROOT / "deploy" / "experiment")
FILE = """
name = "small"
mujoco = "{engine}"
tasks = ["push"]
seeds = [7]
steps = {steps}
milestones = 2
[evaluate]
episodes = 1
placements = ["random", "mt1"]
[set]
"environment.horizon" = 50
"collection.episodes_per_update" = 4
"ppo.minibatch" = 50
[arms.multihead]
method = "multihead"
heads = 5
[arms.ppo]
method = "ppo"
"""
ARMS = FILE[FILE.index("[arms"):]


class Place:
    """A file, and folders for its runs and results."""

    def __init__(self, stage, name="a", steps=1600, text=FILE):
        self._stage = stage
        self.folder = stage.runs.parent / name
        self.folder.mkdir()
        self.file, self.runs, self.results = (self.folder / n for n in ("e.toml", "runs", "results"))
        self.file.write_text(text.format(engine=ENGINE, steps=steps), errors="surrogateescape")

    def start(self, *options, build=BUILD):
        return self._stage.start(EXPERIMENT, self.file, "--build", build, "--runs", self.runs, "--results",
                                 self.results, "--domain", self._stage.domain, "--jobs", 1, *options)

    @property
    def made(self):
        return ResultFiles(self.results / "small")

    def facts(self, run):
        return self.made.runs()[run]

    def curve(self, run):
        return [row for _, row in read_rows(self.made.progress_path("push")) if row["run"] == run]

    def evaluations(self, run):
        return [row for _, row in read_rows(self.made.evaluations_path) if row["run"] == run]

    def evaluated(self, run):
        return [(row["update"], row["placements"]) for row in self.evaluations(run)]


def leave_what_a_killed_start_leaves(folder):
    folder.mkdir(parents=True)
    for name in ("lock", "incarnation"):
        (folder / name).write_text("1\n")


@pytest.mark.slow
def test_it_makes_every_cell_once(stage):
    place = Place(stage)
    leave_what_a_killed_start_leaves(place.runs / "small" / "push-multihead-s7")
    first = place.start()
    assert first.wait() == 0, first
    assert "small: 2 of 2 runs done" in first.text, first
    left = sorted(str(path.relative_to(place.results)) for path in place.results.rglob("*"))
    assert left == [f"small{name}" for name in (
        "", "/evaluations.csv", "/experiment.toml", "/progress", "/progress/push.csv", "/runs.jsonl")]
    curve = place.curve("push-multihead-s7")
    assert [int(row["steps"]) for row in curve] == [200 * i for i in range(1, 9)]
    assert list(curve[0]) == ["run", "steps", "update", "return", "success", "success_end", "wall_seconds"]
    assert place.evaluated("push-multihead-s7") == [("4", "mt1"), ("4", "random"), ("8", "mt1"), ("8", "random")]
    facts = place.facts("push-multihead-s7")
    assert facts["config"] == (place.runs / "small" / "push-multihead-s7" / "config.textproto").read_text()
    assert facts["engine"].endswith(ENGINE) and len(facts["revision"].split("-")[0]) == 40
    assert facts["weights_sha256"] != place.facts("push-ppo-s7")["weights_sha256"]
    # Another start has nothing to do but to remove what a kill may have left; what is done shows.
    (place.made.folder / "push-ppo-s7" / "unfinished").mkdir(parents=True)
    again = place.start()
    assert again.wait() == 0, again
    assert facts == place.facts("push-multihead-s7")
    assert not (place.made.folder / "push-ppo-s7").exists()
    listed = place.start("--list")
    assert listed.wait() == 0 and listed.text.count("done") == 2, listed


@pytest.mark.slow
def test_runs_on_one_placement_are_evaluated_on_it(stage):
    text = FILE.replace('["random", "mt1"]', '["fixed"]').replace("[set]", '[set]\n"environment.placements" = "fixed"')
    place = Place(stage, text=text)
    made = place.start("--cells", "push-ppo-*")
    assert made.wait() == 0, made
    *_, last = place.evaluations("push-ppo-s7")
    assert (last["update"], last["placements"]) == ("8", "fixed")
    by_hand = stage.start(ACTOR, "evaluate", "--json", "--placements", "fixed", "--checkpoint",
                          place.runs / "small" / "push-ppo-s7" / "checkpoints" / "latest")
    assert by_hand.wait() == 0, by_hand
    assert float(last["return"]) == by_hand.json()["return"]
    assert "trained with" not in (place.runs / "small" / "push-ppo-s7.log").read_text()


@pytest.mark.slow
def test_a_cell_is_the_run_that_its_command_makes(stage):
    place = Place(stage)
    made = place.start("--cells", "push-ppo-*")
    assert made.wait() == 0, made
    facts = place.facts("push-ppo-s7")
    words = facts["command"].split()
    assert words[0] == "deploy/train"
    by_hand = stage.start(str(ROOT / words[0]), *words[1:], "--build", BUILD, "--runs", stage.runs,
                          "--run", "by-hand", "--domain", stage.domain, "--actors", 2)
    assert by_hand.wait() == 0, by_hand
    assert stage.inspect(stage.latest("by-hand"))["weights_sha256"] == facts["weights_sha256"]


@pytest.mark.slow
def test_an_interrupted_experiment_goes_on_in_another_checkout(stage):
    whole, cut = Place(stage, "whole", 16000), Place(stage, "cut", 16000)
    calm = whole.start("--cells", "push-multihead-*")
    assert calm.wait() == 0, calm
    stopped = cut.start("--cells", "push-multihead-*")
    stopped.expect_text("push-multihead-s7: under way")
    stopped.signal(signal.SIGINT)
    assert stopped.wait() == 128 + signal.SIGINT, stopped
    assert (cut.results / "small" / "push-multihead-s7" / "unfinished" / "progress.csv").exists(), stopped
    shutil.rmtree(cut.runs)
    resumed = cut.start("--cells", "push-multihead-*")
    assert resumed.wait() == 0, resumed
    assert not (cut.results / "small" / "push-multihead-s7" / "unfinished").exists()
    assert cut.facts("push-multihead-s7") == whole.facts("push-multihead-s7")
    assert cut.evaluations("push-multihead-s7") == whole.evaluations("push-multihead-s7")
    returns = [[row["return"] for row in p.curve("push-multihead-s7")] for p in (whole, cut)]
    assert returns[0] == returns[1] and len(returns[0]) == 80


class HeldEvaluations:
    """Programs whose evaluations never end; the first says when the run has its last checkpoint."""

    def __init__(self, folder):
        self.build, self._said = folder / "held", folder / "said"
        (self.build / "bin").mkdir(parents=True)
        (self.build / "bin" / "metronome-learner").symlink_to(os.path.abspath(LEARNER))
        actor = self.build / "bin" / "metronome-actor"
        actor.write_text(f'#!/bin/sh\n[ "$1" = evaluate ] || exec {shlex.quote(os.path.abspath(ACTOR))} "$@"\n'
                         'until [ -e "$(dirname "$4")/000008.ckpt" ]; do sleep 0.05; done\n'
                         f'echo trained > {shlex.quote(str(self._said))}\nexec sleep 1000\n')
        actor.chmod(0o755)
        os.mkfifo(self._said)
        self._read = os.open(self._said, os.O_RDONLY | os.O_NONBLOCK)

    def expect_trained(self):
        assert select.select([self._read], [], [], DEADLINE)[0], "no evaluation began, or no run ended"
        os.close(self._read)


def stopped_before_an_evaluation(stage):
    """@return where push-ppo-s7 has been trained, and none of its milestones evaluated."""
    place, held = Place(stage), HeldEvaluations(stage.runs.parent)
    stopped = place.start("--cells", "push-ppo-*", build=held.build)
    held.expect_trained()
    stopped.signal(signal.SIGINT)
    assert stopped.wait() == 128 + signal.SIGINT, stopped
    return place


@pytest.mark.slow
def test_a_milestone_that_was_not_evaluated_is_evaluated_in_another_checkout(stage):
    place = stopped_before_an_evaluation(stage)
    result = place.results / "small" / "push-ppo-s7"
    carried = result / "unfinished" / "checkpoints" / "000004.ckpt"
    assert sorted(p.name for p in carried.parent.iterdir()) == ["000004.ckpt", "000008.ckpt"]
    # What was evaluated so far does not mix with other evaluations, here or there.
    expect_other_settings(place, *OTHER_SEED, f"move {place.runs}/small/push-ppo-s7 away")
    shutil.rmtree(place.runs)
    expect_other_settings(place, *OTHER_SEED, f"move {result}/unfinished away")
    # Where it is lost, the cell is not taken for done.
    carried.rename(stage.runs.parent / "kept")
    lost = place.start("--cells", "push-ppo-*")
    assert lost.wait() == 1, lost
    assert "push-ppo-s7: milestones at update 4 " in lost.text and not place.made.runs(), lost
    shutil.rmtree(place.runs)
    (stage.runs.parent / "kept").rename(carried)
    leave_what_a_killed_start_leaves(place.runs / "small" / "push-ppo-s7")
    resumed = place.start("--cells", "push-ppo-*")
    assert resumed.wait() == 0, resumed
    assert place.evaluated("push-ppo-s7") == [("4", "mt1"), ("4", "random"), ("8", "mt1"), ("8", "random")]


@pytest.mark.parametrize("options, complaint", [
    (("--jobs", 0), "--jobs must be at least 1"),
    (("--domain", 233), "--domain must be from 0 to 232"),
    (("--domain", 230, "--jobs", 4), "need domain 233"),
])
def test_jobs_without_a_domain_each_are_refused(stage, options, complaint):
    refused = Place(stage).start(*options)
    assert refused.wait(60) == 2, refused
    assert complaint in refused.text, refused


@pytest.mark.parametrize(
    "old, new, complaint",
    [
        ("seeds =", "seed =", "did you mean 'seeds'"),
        ('tasks = ["push"]', 'tasks = ["pus"]', 'did you mean "push"'),
        ('method = "ppo"', 'method = "pop"', 'did you mean "ppo"'),
        ("heads = 5", "heads = 51", "heads"),
        ('"ppo.minibatch" = 50', '"ppo.minibach" = 50', "minibatch"),
        ("steps = {steps}", "", "steps"),
        ("name =", "name", "line 2"),
        ('name = "small"', "name = 5", "name: 5 cannot"),
        ('name = "small"', 'name = "../small"', "name: '../small' cannot"),
        ("[arms.multihead]", '[arms."a b"]', "[arms.a b]: 'push-a b-s7' cannot"),
        ("[arms.ppo]", f"[arms.{64 * 'p'}]", "ppp]: 'push-ppp"),
        (ARMS, "[arms]", "[arms]: needs at least one arm"),
        (ARMS, "[arms]\nk2 = 5", "[arms.k2]: 5 is not a table"),
        ("heads = 5", "heads = 5\nset = 3", "[arms.multihead] set: 3 is not a table"),
        ("[arms.ppo]", "[task.pull]\nsteps = 5\n[arms.ppo]", "[task]: 'pull' is not one of push"),
        ("[arms.ppo]", "[task]\npush = 5\n[arms.ppo]", "[task.push]: 5 is not a table"),
        ("[evaluate]\nepisodes = 1\nplacements =", "evaluate =", "[evaluate]: ['random', 'mt1'] is not a table"),
        ('"ppo.minibatch" = 50', "ppo.minibatch = 50", '[set]: ppo must be a text, a number, true or false'),
        ('tasks = ["push"]', 'tasks = [["push"]]', "tasks: ['push'] cannot be a name"),
        ('tasks = ["push"]', 'tasks = ["push"] # \udcff', "not UTF-8"),
    ],
)
@pytest.mark.slow
def test_a_file_that_cannot_be_right_is_refused_by_name(stage, old, new, complaint):
    assert old in FILE
    place = Place(stage, text=FILE.replace(old, new))
    refused = place.start()
    assert refused.wait(60) == 2, refused
    assert complaint in refused.text, refused
    assert not place.results.exists()


def expect_other_settings(place, old, new, complaint, remedy):
    asked = place.file.read_text()
    assert old in asked
    place.file.write_text(asked.replace(old, new))
    refused = place.start()
    assert refused.wait(60) == 2, refused
    assert "-s7 was made by" in refused.text and remedy in refused.text, refused
    assert complaint in refused.text, refused
    place.file.write_text(asked)


OTHER_EVALUATION = [
    ("episodes = 1", "episodes = 2", "evaluation_episodes"),
    ('["random", "mt1"]', '["random"]', "evaluation_placements"),
    ("milestones = 2", "milestones = 4", "milestone_every"),
]
OTHER_SEED = ("episodes = 1", "episodes = 1\nseed = 3", "evaluation_seed")


def test_a_file_of_an_editor_of_windows_is_read(stage):
    place = Place(stage)
    place.file.write_bytes(b"\xef\xbb\xbf" + place.file.read_bytes().replace(b"\n", b"\r\n"))
    listed = place.start("--list")
    assert listed.wait(60) == 0, listed
    assert "push-multihead-s7" in listed.text, listed


def test_a_run_whose_newest_checkpoint_is_lost_is_carried_all_the_same(tmp_path):
    cell = SimpleNamespace(experiment="small", name="cell")
    files = CellFiles(cell, tmp_path / "runs", ResultFiles(tmp_path / "results" / "small"))
    folder = tmp_path / "runs" / "small" / "cell" / "checkpoints"
    folder.mkdir(parents=True)
    (folder / "000003.ckpt").write_text("three")
    (folder / "latest").symlink_to("000004.ckpt")
    assert files.carry(set()) is None
    carried = tmp_path / "results" / "small" / "cell" / "unfinished" / "checkpoints"
    assert [path.name for path in carried.iterdir()] == ["000003.ckpt"]


def test_curves_keep_what_is_drawn_and_what_is_of_each_task(tmp_path):
    cell = SimpleNamespace(experiment="small", name="mt10-ppo-s1")
    files = CellFiles(cell, tmp_path / "runs", ResultFiles(tmp_path / "results" / "small"))
    files.run.mkdir(parents=True)
    (files.run / "config.textproto").write_text("seed: 1\n")
    (files.run / "progress.csv").write_text(
        "steps,update,episodes,return,success,success_end,return_push,success_push,kl,kl_head0,wall_seconds,wall_envs\n"
        "400,1,4,2e-04,0.5,0.25,-0.10,0,0.01,0.02,0.7,1\n")
    files.publish({"run": cell.name, "task": "mt10", "arm": "ppo", "seed": 1})
    assert files.results.progress_path("mt10").read_text() == (
        "run,steps,update,return,success,success_end,return_push,success_push,wall_seconds\n"
        "mt10-ppo-s1,400,1,2e-04,0.5,0.25,-0.10,0,0.7\n")


@pytest.mark.slow
def test_a_done_cell_of_other_settings_is_not_taken_for_the_one_asked(stage):
    place = Place(stage)
    assert place.start("--cells", "push-multihead-*").wait() == 0
    for change in (("heads = 5", "heads = 2", "--heads 5"), *OTHER_EVALUATION, OTHER_SEED):
        expect_other_settings(place, *change, f"remove its line from {place.made.runs_path}")


def expect_damage(place, *options):
    refused = place.start(*options)
    assert refused.wait(60) == 2, refused
    assert f"{place.made.runs_path}:1: not a run in JSON" in refused.text, refused


def test_a_damaged_line_is_told_by_its_place(stage):
    place = Place(stage)
    place.made.folder.mkdir(parents=True)
    place.made.runs_path.write_text("<<<<<<< HEAD\n")
    expect_damage(place)
    expect_damage(place, "--list")
    assert place.made.runs_path.read_text() == "<<<<<<< HEAD\n"


@pytest.mark.slow
def test_a_run_that_meets_a_damaged_file_at_its_end_is_kept(stage):
    place = stopped_before_an_evaluation(stage)
    place.made.progress_path("push").parent.mkdir()
    place.made.progress_path("push").write_text("run,steps\n<<<<<<< HEAD\n")
    failed = place.start("--cells", "push-ppo-*")
    assert failed.wait() == 1, failed
    assert f"push-ppo-s7: {place.made.progress_path('push')}:2: 1 fields" in failed.text, failed
    assert not place.made.runs()
    place.made.progress_path("push").unlink()
    again = place.start("--cells", "push-ppo-*")
    assert again.wait() == 0, again
    assert len(place.curve("push-ppo-s7")) == 8
    assert not (place.made.folder / "push-ppo-s7").exists()


@pytest.mark.slow
def test_a_run_that_fails_is_named_and_the_others_are_made(stage):
    place = Place(stage)
    broken = place.runs / "small" / "push-multihead-s7" / "checkpoints"
    broken.mkdir(parents=True)
    (broken / "000001.ckpt").write_text("no checkpoint")
    (broken / "latest").symlink_to("000001.ckpt")
    ended = place.start()
    assert ended.wait() == 1, ended
    assert "push-multihead-s7: deploy/train ended with" in ended.text, ended
    assert list(place.made.runs()) == ["push-ppo-s7"]


@pytest.fixture
def experimenter(monkeypatch):
    """The module behind deploy/experiment."""
    monkeypatch.syspath_prepend(ROOT / "deploy" / "experimenter")
    spec = importlib.util.spec_from_file_location("experimenter", ROOT / "deploy" / "experimenter" / "__main__.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class FullDisk:
    """A slot that can start once the disk has room; its cell is done at once then."""

    free = True

    def __init__(self, tries):
        self.tries, self.started = tries, []

    def advance(self):
        return self.started[0] if self.started else None

    def start(self, cell, files):
        self.tries -= 1
        if self.tries:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.started.append(cell)


class NoEvents:
    def relieve(self, outlets):
        pass

    def wait(self, timeout):
        return []

    def stop(self, children, steps):
        pass

    drain = close = lambda self: None


class SaidBy:
    def __init__(self, said):
        self.note = said.append

    show = done = close = lambda self, *_: None


def test_a_full_disk_is_waited_for_and_told_of_once(experimenter, monkeypatch):
    said = []
    monkeypatch.setattr(experimenter.children, "Events", NoEvents)
    monkeypatch.setattr(experimenter.view, "View", lambda *_: SaidBy(said))
    runner = experimenter.Runner({"cell": None}, set(), [], None, [])
    slot = FullDisk(tries=4)
    runner._slots = [slot]
    assert runner.run() == 0
    assert slot.started == ["cell"]
    assert said == ["waiting until this is over: [Errno 28] No space left on device"]
