"""Heads in each other's blocks of time: what `deploy/exchange` leaves, its table and its figure."""

import numpy as np
import pytest

import cells
import exchange
import synthetic
import tables
from draw import blocks

# A policy of three heads: block 0 needs its head, block 2 does with any.
RETURNS = {"0,1,2": 4000, "1,1,2": 1000, "2,1,2": 400, "0,0,2": 3700, "0,2,2": 2000, "0,1,0": 3900, "0,1,1": 3800,
           "0,0,0": 1500, "1,1,1": 900, "2,2,2": 100}


def test_each_evaluation_finds_its_place(tmp_path):
    synthetic.exchange(tmp_path, "push", RETURNS)
    policy = exchange.found(tmp_path)["push"]
    assert policy.returns.tolist() == [[4000, 1000, 400], [3700, 4000, 2000], [3900, 3800, 4000], [1500, 900, 100]]
    np.testing.assert_allclose(policy.success, policy.returns / 5000)
    assert (policy.episodes, policy.seed) == (50, 4242)
    others, own = policy.of_others(policy.returns)
    assert own == 4000 and others.tolist() == [[1000, 400], [3700, 2000], [3900, 3800]]


def test_the_table_says_which_blocks_need_their_head(tmp_path):
    synthetic.exchange(tmp_path, "push", RETURNS)
    (row,) = [line for line in tables.exchanges(exchange.found(tmp_path)).splitlines() if "push" in line]
    # The mean of the six exchanges: 14800 / 6.
    assert row == "| push | 0.80 | 0.49 | 0.30 | 0.40 | 0.25 | 0.15 | 4000 | 2467 | 1500 | 0 | 2 |"


def test_the_figure_shows_tasks_in_their_order(tmp_path):
    for task in ("push", "assembly"):
        synthetic.exchange(tmp_path, task, RETURNS)
    figure, caption = blocks.exchange(exchange.found(tmp_path))
    assert [ax.get_title(loc="left") for ax in figure.axes[:2]] == ["assembly", "push"]
    assert "50 placements" in caption
    shown = figure.axes[2].images[0].get_array()
    np.testing.assert_allclose(shown[:3].filled(), np.array([[4000, 1000, 400], [3700, 4000, 2000],
                                                             [3900, 3800, 4000]]) / 4000)
    assert shown[3].mask.all()
    np.testing.assert_allclose(shown[4].filled(), np.array([1500, 900, 100]) / 4000)


def test_without_evaluations_there_is_nothing_to_show(tmp_path):
    assert exchange.found(tmp_path) == {}
    assert blocks.exchange({}) is None and tables.exchanges({}) is None


@pytest.mark.parametrize("missing", ["0,1,2", "0,2,2", "1,1,1"])
def test_an_interrupted_file_is_named(tmp_path, missing):
    synthetic.exchange(tmp_path, "push", {order: value for order, value in RETURNS.items() if order != missing})
    with pytest.raises(cells.ResultsError, match="push.csv: .*run it again"):
        exchange.found(tmp_path)
