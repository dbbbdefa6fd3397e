"""The statistics, against numbers that scipy, rliable or counting by hand give."""

import itertools

import numpy as np
import pytest
import scipy.stats
from rliable import metrics

import estimates


@pytest.fixture
def scores():
    return np.random.default_rng(7).normal(size=(5, 4))


@pytest.mark.parametrize("runs, tasks", [(1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (5, 4), (10, 3)])
def test_the_interquartile_mean_is_that_of_scipy_and_of_rliable(runs, tasks):
    scores = np.random.default_rng(runs).normal(size=(runs, tasks))
    got = estimates.interquartile_mean(scores)
    assert got == pytest.approx(scipy.stats.trim_mean(scores, 0.25, axis=None), abs=1e-12)
    assert got == pytest.approx(metrics.aggregate_iqm(scores), abs=1e-12)


def test_of_five_scores_the_middle_three_count():
    assert estimates.interquartile_mean(np.array([[100.0], [1], [2], [6], [-50]])) == pytest.approx(3)


def test_interquartile_means_of_curves_are_taken_point_by_point():
    curves = np.random.default_rng(3).normal(size=(5, 7))
    mean, low, high = estimates.band(curves)
    assert mean == pytest.approx(scipy.stats.trim_mean(curves, 0.25, axis=0))
    assert np.all(low <= mean) and np.all(mean <= high)


def test_the_interval_is_the_percentile_interval_of_all_resamples():
    """Of 3 runs there are 27 resamples, that can all be written down."""
    scores = [1.0, 2.0, 4.0]
    means = np.sort([np.mean(resample) for resample in itertools.product(scores, repeat=3)])
    got = estimates.iqm([scores])
    # With 2000 resamples a percentile may fall one of the 27 steps beside the exact one.
    assert means[0] <= got.low <= means[3]
    assert means[-4] <= got.high <= means[-1]
    assert (got.value, got.seeds) == (pytest.approx(7 / 3), 3)


def test_tasks_are_resampled_each_on_their_own():
    """Where runs of a task do not differ there is nothing to be unsure of."""
    got = estimates.iqm([[1.0] * 4, [3.0] * 4])
    assert (got.value, got.low, got.high) == (2, 2, 2)


def test_two_seeds_have_no_interval():
    assert estimates.iqm([[1.0, 3.0]]) == estimates.Estimate(2.0, None, None, 2)
    assert estimates.band([[1.0, 2.0], [3.0, 4.0]])[1:] == (None, None)
    assert estimates.difference({1: 1.0, 2: 2.0}, {1: 0.0, 2: 0.0}).p is None


def test_unequal_numbers_of_seeds_are_cut_to_the_smallest():
    assert estimates.matrix([[1, 2, 3], [4, 5]]).tolist() == [[1, 4], [2, 5]]


def test_the_probability_of_improvement_is_that_of_rliable(scores):
    other = np.round(scores[:4] + 0.3, 1)
    scores = np.round(scores, 1)  # so that there are ties
    assert estimates.improvement(scores, other) == pytest.approx(
        metrics.probability_of_improvement(scores, other), abs=1e-12)


def test_the_probability_of_improvement_counts_ties_half():
    got = estimates.probability_of_improvement([[1, 2, 3]], [[2, 2, 0]])
    assert got.value == pytest.approx((0 + 0 + 1 + 0.5 + 0.5 + 1 + 1 + 1 + 1) / 9)
    assert got.low <= got.value <= got.high


def test_a_profile_is_the_share_of_runs_above(scores):
    thresholds = np.array([-10.0, 0.0, 10.0])
    share, low, high = estimates.profile(list(scores.T), thresholds)
    assert share.tolist() == [1, np.mean(scores > 0), 0]
    assert low[1] < share[1] < high[1]


def test_a_difference_over_common_seeds_is_paired():
    """The seeds' own level, 100 times the difference, cancels out of the interval."""
    x = {seed: 100.0 * seed + 1 + 0.01 * seed for seed in (1, 2, 3, 4)}
    y = {seed: 100.0 * seed for seed in (2, 3, 4, 9)}
    got = estimates.difference(x, y)
    assert got.paired and got.seeds == (3, 3)
    assert got.estimate.value == pytest.approx(1.03)
    assert 1.0 < got.estimate.low <= got.estimate.high < 1.1


def test_a_difference_without_common_seeds_is_unpaired():
    got = estimates.difference({1: 5.0, 2: 6.0, 3: 7.0}, {4: 1.0, 5: 2.0, 6: 3.0, 7: 2.0})
    assert not got.paired and got.seeds == (3, 4)
    assert got.estimate.value == pytest.approx(4)
    assert got.estimate.low < 4 < got.estimate.high


def test_p_counts_the_splits_that_differ_as_much():
    x, y = [3.0, 4.0, 5.0, 1.5], [1.0, 2.0, 2.5, 0.0]
    pool, observed = np.array(x + y), np.mean(x) - np.mean(y)
    splits = list(itertools.combinations(range(8), 4))
    differences = np.array([pool[list(s)].mean() - np.delete(pool, list(s)).mean() for s in splits])
    exact = np.mean(np.abs(differences) >= abs(observed) - 1e-12)
    assert estimates.difference(dict(enumerate(x)), dict(enumerate(y))).p == pytest.approx(exact)


def test_complete_separation_of_five_and_five_has_the_smallest_p():
    got = estimates.difference({s: 10.0 + s for s in range(5)}, {s: float(s) for s in range(5)})
    assert got.p == pytest.approx(2 / 252)


@pytest.mark.parametrize("n, m", [(3, 3), (5, 5), (3, 5), (4, 3)])
def test_the_smallest_possible_p_is_that_of_complete_separation(n, m):
    got = estimates.difference({s: 10.0 + s for s in range(n)}, {-1 - s: -float(s) for s in range(m)})
    assert got.p == pytest.approx(estimates.smallest_p(n, m))


def test_no_difference_at_all_is_certain_of_nothing():
    got = estimates.difference({s: 0.0 for s in range(5)}, {s: 0.0 for s in range(5)})
    assert (got.estimate.low, got.estimate.high, got.p) == (0, 0, 1)


def test_a_trend_is_spearmans_correlation():
    levels = np.repeat([1, 2, 5, 10, 20, 50], 5)
    values = np.round(np.random.default_rng(3).random(30) + 0.01 * levels, 1)
    correlation, p = estimates.trend(levels, values)
    expected = scipy.stats.spearmanr(levels, values)
    assert correlation == pytest.approx(expected.statistic, abs=1e-12)
    assert p == pytest.approx(expected.pvalue, abs=0.01) and 0.001 < p < 0.9


def test_p_of_a_trend_counts_the_orders_that_agree_as_much():
    assert estimates.trend([1, 2, 5, 10], [3.0, 4, 6, 7]) == pytest.approx((1, 2 / 24))
    assert estimates.trend([1, 2, 5, 10], [7.0, 6, 4, 3]) == pytest.approx((-1, 2 / 24))


@pytest.mark.parametrize("levels, values", [([1, 1, 1], [1, 2, 3]), ([1, 2, 3], [0, 0, 0]), ([1, 2], [1, 2])])
def test_there_is_no_trend_in_what_does_not_vary(levels, values):
    assert estimates.trend(levels, values) is None


def test_a_difference_over_tasks_leaves_out_those_with_too_few_pairs():
    x = [{1: 1.0, 2: 2.0, 3: 3.0}, {1: 5.0, 2: 5.0, 3: 5.0}, {1: 1000.0}]
    y = [{1: 0.0, 2: 0.0, 3: 0.0}, {1: 1.0, 2: 1.0, 3: 1.0}, {1: 0.0}]
    estimate, tasks = estimates.pooled_difference(x, y)
    assert (estimate.value, tasks) == (pytest.approx(3), 2)
    assert 2.5 <= estimate.low <= 3 <= estimate.high <= 3.5
    assert estimates.pooled_difference(x[:1], y[:1]) is None


def test_with_enough_seeds_the_interval_over_tasks_is_that_of_the_seeds(scores):
    assert estimates.iqm_over_tasks(list(scores.T)) == estimates.iqm(list(scores.T))


def test_with_one_seed_tasks_are_resampled():
    values = [1.0, 2.0, 4.0]
    got = estimates.iqm_over_tasks([[value] for value in values])
    assert (got.value, got.seeds) == (pytest.approx(7 / 3), 1)
    as_runs = estimates.iqm([values])
    assert (got.low, got.high) == (as_runs.low, as_runs.high)
    assert estimates.iqm_over_tasks([[1.0], [2.0]]).low is None


def test_a_sign_test_counts_tasks_that_differ():
    # 8 or 9 heads of 9 coins, or tails: 2 * (9 + 1) / 2^9. What rounding leaves of no difference is none.
    got = estimates.signs([0.1] * 8 + [-0.3] + [0.0, 0.3 - 0.1 - 0.2])
    assert got == estimates.Signs(8, 1, 2, pytest.approx(20 / 512))
    assert estimates.signs([0.0, 0.0]) == estimates.Signs(0, 0, 2, None)


def test_two_groups_are_contrasted_over_all_ways_to_deal_them():
    difference, p = estimates.contrast([0.8, 0.9, 0.7], [0.0, 0.1, 0.2, 0.1])
    assert (difference, p) == (pytest.approx(0.7), pytest.approx(2 / 35))
    assert estimates.contrast([0.8], [0.0, 0.1, 0.2])[1] is None


def test_the_same_scores_give_the_same_interval_after_anything(scores):
    first = estimates.iqm(list(scores.T))
    np.random.uniform(size=100)
    assert estimates.iqm(list(scores.T)) == first
