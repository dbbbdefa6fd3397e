"""From rows to curves, against sums written out."""

import numpy as np
import pytest

import curves


def table(steps, values):
    return {"steps": np.array(steps, dtype=float), "success": np.array(values, dtype=float)}


def test_a_trailing_mean_takes_what_is_in_its_window():
    x, values = np.array([1.0, 2, 3, 4, 5]), np.array([10.0, 20, 30, 40, 50])
    got = curves.trailing_mean(x, values, np.array([1.0, 3, 4.5, 5]), 2.0)
    assert got.tolist() == [10, 25, 35, 45]


def test_a_window_without_rows_takes_the_newest_one_before():
    got = curves.trailing_mean(np.array([1.0, 10]), np.array([3.0, 7]), np.array([0.5, 8.0]), 1.0)
    assert got.tolist() == [3, 3]


def test_curves_of_unequal_length_end_with_the_shortest():
    long, short = table(range(1, 201), range(200)), table(range(1, 51), range(50))
    grid, values = curves.smooth([long, short], "success")
    assert values.shape == (2, 50) and grid[-1] == 50
    assert values[0] == pytest.approx(values[1])
    assert values[0][-1] == pytest.approx((48 + 49) / 2)  # 4 % of 50: two rows


def test_curves_of_unequal_spacing_share_a_grid():
    fine, coarse = table(range(10, 1001, 10), [1.0] * 100), table(range(50, 1001, 50), [2.0] * 20)
    grid, values = curves.smooth([fine, coarse], "success")
    assert len(grid) == 20 and np.all(values[0] == 1) and np.all(values[1] == 2)


def test_only_milestones_that_every_run_has_are_averaged():
    steps, values = curves.common_rows([table([1, 2, 3], [1, 2, 3]), table([2, 3, 4], [5, 6, 7])], "success")
    assert steps.tolist() == [2, 3] and values.tolist() == [[2, 3], [5, 6]]


def test_the_end_is_the_last_ten_updates():
    assert curves.at_end(table(range(1, 31), [0] * 20 + [1] * 10), "success") == 1
    assert curves.at_end(table([1, 2], [0, 1]), "success") == 0.5


def test_success_under_noise_is_reached_by_ten_updates_not_by_one():
    values = np.array([1.0] + [0.0] * 15 + [1.0] * 14)
    averages = curves.noise_average(values)
    assert np.isnan(averages[:9]).all() and averages[9] == pytest.approx(0.1)
    assert curves.first_reach(np.arange(1, 31), averages, 0.9) == 25


def test_what_is_never_reached_is_none():
    assert curves.first_reach(np.array([1, 2]), np.array([0.1, 0.89]), 0.9) is None


def test_minutes_are_those_of_the_update_at_these_steps():
    progress = {"steps": np.array([100.0, 200, 300]), "wall_seconds": np.array([60.0, 120, 600])}
    assert [curves.minutes_at(progress, steps) for steps in (100, 200, 250, 999)] == [1, 2, 10, 10]
