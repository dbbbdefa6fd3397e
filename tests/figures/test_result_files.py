"""Finished runs are added to their experiment's files: each as one block, whole or not at all."""

import difflib
import multiprocessing

import pytest

import result_files
from result_files import ResultFiles, ResultsError


def publish(files, arm="ppo", seed=1, task="push", progress=None, evaluations=None):
    files.publish({"run": f"{task}-{arm}-s{seed}", "task": task, "arm": arm, "seed": seed, "config": "seed: 1\n"},
                  progress or [{"steps": "8000", "return": "2e-04"}, {"steps": "16000", "return": "-0.10"}],
                  evaluations or [{"steps": "16000", "success": "0.0", "time_to_success": ""}])


def contents(files):
    return {str(path.relative_to(files.folder)): path.read_text()
            for path in sorted(files.folder.rglob("*")) if path.is_file()}


@pytest.fixture
def files(tmp_path):
    return ResultFiles(tmp_path / "main")


def test_a_run_is_four_files(files):
    publish(files)
    assert contents(files) == {
        "experiment.toml": "",
        "evaluations.csv": "run,steps,success,time_to_success\npush-ppo-s1,16000,0.0,\n",
        "progress/push.csv": "run,steps,return\npush-ppo-s1,8000,2e-04\npush-ppo-s1,16000,-0.10\n",
        "runs.jsonl": '{"run": "push-ppo-s1", "task": "push", "arm": "ppo", "seed": 1, "config": "seed: 1\\n"}\n'}
    assert files.runs()["push-ppo-s1"]["config"] == "seed: 1\n"


def test_a_new_run_is_one_block_of_each_file(files):
    for arm, seed in (("ppo", 10), ("ppo", 1), ("ppo-time", 1)):
        publish(files, arm, seed)
    before = contents(files)
    publish(files, "ppo", 9)
    for name, text in contents(files).items():
        changes = [line for line in difflib.ndiff(before[name].splitlines(), text.splitlines()) if line[0] in "+-?"]
        assert len(changes) == {"experiment.toml": 0, "progress/push.csv": 2}.get(name, 1)
        assert all(line.startswith("+ ") and "push-ppo-s9" in line for line in changes)
    assert list(files.runs()) == ["push-ppo-s1", "push-ppo-s9", "push-ppo-s10", "push-ppo-time-s1"]


def test_files_do_not_tell_who_finished_first(files, tmp_path):
    other = ResultFiles(tmp_path / "other")
    runs = [("ppo", 1, "push"), ("ppo", 2, "push"), ("k2", 1, "reach")]
    for run in runs:
        publish(files, *run)
    for run in reversed(runs):
        publish(other, *run)
    assert contents(files) == contents(other)


def test_a_column_that_a_run_lacks_is_empty(files):
    publish(files, "a")
    publish(files, "b", evaluations=[{"steps": "16000", "success": "1.0", "time_to_success": "", "success_200": "0.5"}])
    publish(files, "c")
    assert files.evaluations_path.read_text() == (
        "run,steps,success,time_to_success,success_200\n"
        "push-a-s1,16000,0.0,,\npush-b-s1,16000,1.0,,0.5\npush-c-s1,16000,0.0,,\n")


@pytest.mark.parametrize("writes", range(3))
def test_a_run_whose_publishing_is_cut_is_not_finished_and_can_be_published_again(files, tmp_path, monkeypatch, writes):
    whole = ResultFiles(tmp_path / "whole")
    for each in (files, whole):
        publish(each, "k2")
    publish(whole)
    with monkeypatch.context() as patch:
        left, write = [writes], result_files.whole_files.write

        def write_or_stop(path, text):
            if not left[0]:
                raise KeyboardInterrupt
            left[0] -= 1
            write(path, text)

        patch.setattr(result_files.whole_files, "write", write_or_stop)
        with pytest.raises(KeyboardInterrupt):
            publish(files)
    assert list(files.runs()) == ["push-k2-s1"]
    publish(files)
    assert contents(files) == contents(whole)


@pytest.mark.parametrize("name, line, said", [
    ("runs.jsonl", "<<<<<<< HEAD\n", r"runs\.jsonl:2: not a run"),
    ("evaluations.csv", "<<<<<<< HEAD\n", r"evaluations\.csv:3: 1 fields"),
    ("progress/push.csv", "push-k2-s1,24", r"push\.csv:4: 2 fields"),
    ("progress/push.csv", "push-k2-s1,24000,1", r"push\.csv:4: .* cut"),
])
def test_a_damaged_file_is_named_and_left_as_it_is(files, name, line, said):
    publish(files, "k2")
    with open(files.folder / name, "a") as file:
        file.write(line)
    damaged = (files.folder / name).read_text()
    with pytest.raises(ResultsError, match=said):
        publish(files)
    assert (files.folder / name).read_text() == damaged
    assert "push-ppo-s1" not in files.runs_path.read_text()


def publish_seeds(folder, arm):
    for seed in range(1, 11):
        publish(ResultFiles(folder), arm, seed)


def test_processes_that_publish_at_once_lose_nothing(files):
    processes = [multiprocessing.Process(target=publish_seeds, args=(files.folder, arm)) for arm in "abcd"]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
        assert process.exitcode == 0
    assert len(files.runs()) == 40
    assert len(list(result_files.read_rows(files.progress_path("push")))) == 80
