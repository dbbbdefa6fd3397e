"""The benchmarks still run; their figures are not judged."""

import csv
import subprocess

from harness import ENGINE, ROOT



def test_the_benchmarks_that_need_no_peers_run_and_keep_their_figures(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"<!-- table loops {ENGINE} -->\n<!-- end -->\n")
    command = [ROOT / "tests/bench/run", "loops", "--quick", "--tasks", "push", "--mujoco", ENGINE]
    command += ["--no-build", "--out", tmp_path, "--page", page]
    subprocess.run(command, check=True, timeout=120, cwd=ROOT)
    with open(tmp_path / "loops-quick.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["quantity"] for row in rows} == {"bare x1", "bare x2", "actor x1", "actor x2"}
    assert all(row["engine"] == ENGINE and float(row["value"]) > 0 for row in rows)
    assert "| push | " in page.read_text()
