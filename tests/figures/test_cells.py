"""Reading results: what is there is used, what is damaged is named."""

import numpy as np
import pytest

import cells
import scores
import synthetic


def replace_line(path, number, change):
    lines = path.read_text().splitlines(keepends=True)
    lines[number - 1] = change(lines[number - 1])
    path.write_text("".join(lines))


@pytest.fixture
def files(tmp_path):
    return synthetic.cell(tmp_path, "main", "push", "ppo-time", 3, method="ppo-time", heads=1)


def read_one(files):
    (cell,), unfinished = cells.read_experiment(files.folder)
    assert not unfinished
    return cell


def test_a_cell_is_read_as_it_was_written(files):
    cell = read_one(files)
    assert (cell.experiment, cell.task, cell.arm, cell.seed) == ("main", "push", "ppo-time", 3)
    assert (cell.method, cell.heads, cell.horizon, cell.steps) == ("ppo-time", 1, 500, 2_000_000)
    assert len(cell.progress["return"]) == 50 and len(cell.evaluations["random"]["steps"]) == 4
    assert cell.largest_return == 5000


def test_each_run_gets_the_rows_of_its_own(tmp_path, files):
    alone = read_one(files)
    for task, arm, seed in (("push", "ppo", 3), ("push", "ppo-time", 12), ("reach", "ppo-time", 3)):
        synthetic.cell(tmp_path, "main", task, arm, seed, level=0.2)
    found, _ = cells.read_experiment(files.folder)
    (same,) = (cell for cell in found if (cell.task, cell.arm, cell.seed) == ("push", "ppo-time", 3))
    assert len(found) == 4
    for column in cells.PROGRESS:
        assert (same.progress[column] == alone.progress[column]).all()
    assert same.evaluations["random"]["return"].tolist() == alone.evaluations["random"]["return"].tolist()


def test_unfinished_runs_are_named_and_left_out(files, tmp_path):
    synthetic.cell(tmp_path, "main", "push", "ppo", 1)
    lines = files.runs_path.read_text().splitlines(keepends=True)
    files.runs_path.write_text(lines[1])
    (files.folder / "push-multihead-s2" / "unfinished").mkdir(parents=True)
    experiments, unfinished = cells.read_results(tmp_path)
    assert [cell.arm for cell in experiments["main"]] == ["ppo-time"]
    assert unfinished == ["main/push-multihead-s2", "main/push-ppo-s1"]


def test_other_folders_of_results_are_no_experiments(files, tmp_path):
    (tmp_path / "performance" / "curves").mkdir(parents=True)
    assert list(cells.read_results(tmp_path)[0]) == ["main"]


def test_no_results_at_all_say_what_to_do(tmp_path):
    with pytest.raises(cells.ResultsError, match="no finished run.*deploy/experiment"):
        cells.read_results(tmp_path)


def test_a_run_without_evaluation_is_used(files):
    files.evaluations_path.unlink()
    assert read_one(files).evaluations == {}


def test_a_run_without_a_curve_is_named(files):
    files.progress_path("push").write_text("run,steps,return,success,success_end,wall_seconds\n")
    with pytest.raises(cells.ResultsError, match=r"progress/push\.csv has no rows of push-ppo-time-s3"):
        cells.read_experiment(files.folder)
    files.progress_path("push").unlink()
    with pytest.raises(cells.ResultsError, match=r"progress/push\.csv cannot be read: No such file"):
        cells.read_experiment(files.folder)


def test_evaluations_from_before_success_by_step_200_are_used(files):
    path = files.evaluations_path
    assert scores.DETERMINISTIC_200.of(read_one(files)) is not None
    assert path.read_text().splitlines()[0].endswith(",success_200")
    path.write_text("".join(line.rsplit(",", 1)[0] + "\n" for line in path.read_text().splitlines()))
    cell = read_one(files)
    assert np.isnan(cell.evaluations["random"]["success_200"]).all()
    assert scores.DETERMINISTIC_200.of(cell) is None and scores.DETERMINISTIC.of(cell) is not None


@pytest.mark.parametrize("change, said", [
    (lambda line: line.replace(",", ";"), "1 fields where"),
    (lambda line: line.rsplit(",", 1)[0] + "\n", "6 fields where the first line names 7"),
    (lambda line: line.strip() + ",1\n", "8 fields where"),
    (lambda line: line[: len(line) // 2], "fields where|cannot be a value"),
    (lambda line: line.replace(",", ",x", 1), "column steps"),
    (lambda line: line.replace("-s3,", ",", 1), "'push-ppo-time' cannot be a run"),
    (lambda line: line.replace(",", ",nan,", 1).rsplit(",", 1)[0] + "\n", "cannot be a value"),
    (lambda line: line.split(",")[0] + ",5," + line.split(",", 2)[2], "does not grow"),
])
def test_a_damaged_row_names_file_and_line(files, change, said):
    replace_line(files.progress_path("push"), 7, change)
    with pytest.raises(cells.ResultsError, match=rf"main/progress/push\.csv:7: .*({said})"):
        cells.read_experiment(files.folder)


def test_a_file_cut_inside_its_last_number_is_damaged(files):
    path = files.progress_path("push")
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(cells.ResultsError, match=r"push\.csv:51: .* cut"):
        cells.read_experiment(files.folder)


def test_a_share_above_one_is_damage(files):
    replace_line(files.evaluations_path, 3, lambda line: ",".join([*line.split(",")[:5], "1.5", *line.split(",")[6:]]))
    with pytest.raises(cells.ResultsError, match=r"evaluations\.csv:3: '1.5' .* column success"):
        cells.read_experiment(files.folder)


@pytest.mark.parametrize("name", ["runs.jsonl", "evaluations.csv", "progress/push.csv"])
def test_bytes_that_are_no_text_name_the_file(files, name):
    (files.folder / name).write_bytes(b"run,steps,return\n\xff\xfe\n")
    with pytest.raises(cells.ResultsError, match=name):
        cells.read_experiment(files.folder)


@pytest.mark.parametrize("name, column", [
    ("progress/push.csv", "return"), ("progress/push.csv", "run"), ("evaluations.csv", "placements")])
def test_a_missing_column_is_named(files, name, column):
    replace_line(files.folder / name, 1, lambda line: line.replace(column, "other"))
    with pytest.raises(cells.ResultsError, match=rf"{name}:1: there is no column {column}"):
        cells.read_experiment(files.folder)


@pytest.mark.parametrize("change, said", [
    (lambda line: "{\n", "runs.jsonl:2: not a run in JSON"),
    (lambda line: "<<<<<<< HEAD\n", "runs.jsonl:2: not a run in JSON"),
    (lambda line: line[: len(line) // 2], "runs.jsonl:2: not a run in JSON"),
    (lambda line: "[]\n", "runs.jsonl:2: no usable entry"),
    (lambda line: '{"task": "push"}\n', "runs.jsonl:2: no usable entry 'run'"),
    (lambda line: line.replace('"task": "push"', '"task": "reach"'), "'push-ppo-time-s3' tells of reach-ppo-time-s3"),
    (lambda line: line.replace('"seed": 3', '"seed": "3"'), "runs.jsonl:2: not a run in JSON"),
    (lambda line: line + line, "runs.jsonl:3: another line of push-ppo-time-s3"),
    (lambda line: line.replace("horizon", "horizont"), "push-ppo-time-s3: its configuration does not name the horizon"),
    (lambda line: line.replace('"heads"', '"hats"'), "push-ppo-time-s3: no usable entry 'heads'"),
])
def test_a_damaged_line_of_runs_is_named(tmp_path, files, change, said):
    synthetic.cell(tmp_path, "main", "push", "ppo", 1)
    replace_line(files.runs_path, 2, change)
    with pytest.raises(cells.ResultsError, match=said):
        cells.read_experiment(files.folder)
