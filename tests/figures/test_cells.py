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
def folder(tmp_path):
    return synthetic.cell(tmp_path, "main", "push", "ppo-time", 3, method="ppo-time", heads=1)


def test_a_cell_is_read_as_it_was_written(folder):
    cell = cells.read_cell(folder)
    assert (cell.experiment, cell.task, cell.arm, cell.seed) == ("main", "push", "ppo-time", 3)
    assert (cell.method, cell.heads, cell.horizon, cell.steps) == ("ppo-time", 1, 500, 2_000_000)
    assert len(cell.progress["return"]) == 50 and len(cell.evaluations["random"]["steps"]) == 4
    assert cell.largest_return == 5000


def test_unfinished_cells_are_named_and_left_out(folder, tmp_path):
    other = synthetic.cell(tmp_path, "main", "push", "ppo", 1)
    (other / "run.json").unlink()
    experiments, unfinished = cells.read_results(tmp_path)
    assert [cell.arm for cell in experiments["main"]] == ["ppo-time"]
    assert unfinished == [other]


def test_other_folders_of_results_are_no_experiments(folder, tmp_path):
    (tmp_path / "performance" / "curves").mkdir(parents=True)
    assert list(cells.read_results(tmp_path)[0]) == ["main"]


def test_no_results_at_all_say_what_to_do(tmp_path):
    with pytest.raises(cells.ResultsError, match="no finished run.*deploy/experiment"):
        cells.read_results(tmp_path)


def test_a_cell_without_evaluation_is_used(folder):
    (folder / "evaluation.csv").unlink()
    assert cells.read_cell(folder).evaluations == {}


def test_evaluations_from_before_success_by_step_200_are_used(folder):
    path = folder / "evaluation.csv"
    assert scores.DETERMINISTIC_200.of(cells.read_cell(folder)) is not None
    path.write_text("".join(line.rsplit(",", 1)[0] + "\n" for line in path.read_text().splitlines()))
    cell = cells.read_cell(folder)
    assert np.isnan(cell.evaluations["random"]["success_200"]).all()
    assert scores.DETERMINISTIC_200.of(cell) is None and scores.DETERMINISTIC.of(cell) is not None


@pytest.mark.parametrize("change, said", [
    (lambda line: line.replace(",", ";"), "1 fields where"),
    (lambda line: line.rsplit(",", 1)[0] + "\n", "8 fields where the first line names 9"),
    (lambda line: line.strip() + ",1\n", "10 fields where"),
    (lambda line: line[: len(line) // 2], "fields where|cannot be a value"),
    (lambda line: "x" + line, "column steps"),
    (lambda line: line.replace(",", ",nan,", 1).rsplit(",", 1)[0] + "\n", "cannot be a value"),
    (lambda line: "5" + line[line.index(","):], "does not grow"),
])
def test_a_damaged_row_names_file_and_line(folder, change, said):
    replace_line(folder / "progress.csv", 7, change)
    with pytest.raises(cells.ResultsError, match=rf"push-ppo-time-s3/progress\.csv:7: .*({said})"):
        cells.read_cell(folder)


def test_a_file_cut_inside_its_last_number_is_damaged(folder):
    path = folder / "progress.csv"
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(cells.ResultsError, match=r"progress\.csv:51: .* cut"):
        cells.read_cell(folder)


def test_a_share_above_one_is_damage(folder):
    path = folder / "evaluation.csv"
    replace_line(path, 3, lambda line: ",".join([*line.split(",")[:4], "1.5", *line.split(",")[5:]]))
    with pytest.raises(cells.ResultsError, match=r"evaluation\.csv:3: '1.5' .* column success"):
        cells.read_cell(folder)


def test_bytes_that_are_no_text_name_the_file(folder):
    (folder / "progress.csv").write_bytes(b"steps,return\n\xff\xfe\n")
    with pytest.raises(cells.ResultsError, match="progress.csv"):
        cells.read_cell(folder)


def test_a_missing_column_is_named(folder):
    replace_line(folder / "progress.csv", 1, lambda line: line.replace("return", "reward"))
    with pytest.raises(cells.ResultsError, match=r"progress\.csv:1: there is no column return"):
        cells.read_cell(folder)


def test_run_json_must_be_that_of_its_folder(folder):
    (folder / "run.json").write_text((folder / "run.json").read_text().replace("push", "assembly"))
    with pytest.raises(cells.ResultsError, match="is that of assembly-ppo-time-s3"):
        cells.read_cell(folder)


@pytest.mark.parametrize("text", ["{", "[]", '{"task": "push"}'])
def test_a_damaged_run_json_is_named(folder, text):
    (folder / "run.json").write_text(text)
    with pytest.raises(cells.ResultsError, match="run.json"):
        cells.read_cell(folder)
