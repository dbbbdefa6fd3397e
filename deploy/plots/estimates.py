"""The statistics: point estimates and intervals of a few seeds.

Aggregates follow Agarwal et al., "Deep Reinforcement Learning at the Edge of the Statistical
Precipice", arXiv:2108.13264, by their own library (rliable): interquartile means with percentile
intervals of a stratified bootstrap, probability of improvement, performance profiles. Differences of
two arms on one task have a bootstrap interval and an exact permutation test; so has a trend.

Every resampling starts from the same fixed seed, so that the same scores give the same numbers.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy.stats
from rliable import library

RESAMPLES = 2000
CONFIDENCE = 0.95
FEWEST = 3  # seeds that an interval needs; with fewer, resamples hardly differ
# Of one test: all splits of 2 x 9 seeds are fewer than this, and are then all tried.
_SPLITS = 50000
_SEED = 20240101


@dataclass(frozen=True)
class Estimate:
    """A point estimate and its 95 % interval; `low` and `high` are None where seeds are too few."""

    value: float
    low: float | None
    high: float | None
    seeds: int  # of each task, where there are several


@dataclass(frozen=True)
class Signs:
    """In how many tasks one arm is better than another."""

    better: int
    worse: int
    equal: int
    p: float | None  # two-sided binomial test of the tasks that differ, exact; None where none does


@dataclass(frozen=True)
class Difference:
    """One arm's mean less another's, on one task."""

    estimate: Estimate  # of the mean difference
    paired: bool  # the interval resamples pairs of equal seed; otherwise each arm on its own
    p: float | None  # two-sided permutation test of the difference of means
    seeds: tuple  # of either arm


def interquartile_mean(scores):
    """Mean of what remains of axes 0 and 1 without the lowest and the highest quarter (each rounded
    down: of 5 scores the middle 3 remain, of 3 all).
    @param scores  (runs, tasks, ...).  @return (...)."""
    pooled = np.sort(scores.reshape(-1, *scores.shape[2:]), axis=0)
    cut = len(pooled) // 4
    return pooled[cut : len(pooled) - cut].mean(axis=0)


def improvement(x, y):
    """P(X > Y), ties counted half, averaged over tasks.  @param x, y  (runs, tasks)."""
    wins = (x[:, None] > y[None]) + 0.5 * (x[:, None] == y[None])
    return wins.mean()


def _interval(scores, function):
    # rliable draws from numpy's global generator, whatever it is given.
    np.random.seed(_SEED)
    _, intervals = library.get_interval_estimates(
        {"": scores}, lambda *arrays: np.atleast_1d(function(*arrays)),
        reps=RESAMPLES, confidence_interval_size=CONFIDENCE)
    return intervals[""]


def _estimate(function, *arrays):
    value, seeds = float(function(*arrays)), min(len(array) for array in arrays)
    if seeds < FEWEST:
        return Estimate(value, None, None, seeds)
    low, high = _interval(arrays[0] if len(arrays) == 1 else list(arrays), function)
    return Estimate(value, float(low[0]), float(high[0]), seeds)


def matrix(by_task):
    """(runs, tasks) of lists of unequal length: the first n of each, n being the shortest's length."""
    runs = min(len(scores) for scores in by_task)
    return np.array([list(scores)[:runs] for scores in by_task], dtype=float).T


def iqm(by_task):
    """@param by_task  a list of scores, one each seed, for each task.
    @return the interquartile mean over all, resampled within each task (see `matrix`)."""
    return _estimate(interquartile_mean, matrix(by_task))


def iqm_over_tasks(by_task):
    """As `iqm`; where seeds are too few for an interval, the tasks' means are resampled in place of runs."""
    estimate = iqm(by_task)
    if estimate.low is not None:
        return estimate
    return replace(iqm([[np.mean(scores) for scores in by_task]]), seeds=estimate.seeds)


def probability_of_improvement(x_by_task, y_by_task):
    """That a run of X scores better than one of Y on the same task, averaged over tasks."""
    return _estimate(improvement, matrix(x_by_task), matrix(y_by_task))


def band(curves):
    """@param curves  (runs, points).  @return (mean, low, high), (points) each, of interquartile means;
    low and high are None where runs are too few."""
    scores = np.asarray(curves, dtype=float)[:, None, :]
    mean = interquartile_mean(scores)
    if len(scores) < FEWEST:
        return mean, None, None
    low, high = _interval(scores, interquartile_mean)
    return mean, low, high


def profile(by_task, thresholds):
    """Performance profile: share of runs whose score is above each threshold.
    @return (share, low, high), (thresholds) each; low and high are None where seeds are too few."""
    scores = matrix(by_task)
    share = np.array([(scores > threshold).mean() for threshold in thresholds])
    if len(scores) < FEWEST:
        return share, None, None
    low, high = _interval(scores, lambda x: (x[..., None] > thresholds).mean(axis=(0, 1)))
    return share, low, high


def difference(x_by_seed, y_by_seed):
    """@param x_by_seed, y_by_seed  seed to score, of two arms on one task.
    @return X less Y. Where both arms have `FEWEST` seeds or more in common, these alone are used and the
    interval resamples their differences; otherwise it resamples each arm on its own."""
    common = sorted(x_by_seed.keys() & y_by_seed.keys())
    paired = len(common) >= FEWEST
    x, y = (np.array([scores[seed] for seed in (common if paired else sorted(scores))], dtype=float)
            for scores in (x_by_seed, y_by_seed))
    if paired:
        estimate = _estimate(np.mean, (x - y)[:, None])
    else:
        estimate = _estimate(lambda a, b: a.mean() - b.mean(), x[:, None], y[:, None])
    return Difference(estimate, paired, _permutation_test(x, y), (len(x), len(y)))


def smallest_p(x_seeds, y_seeds):
    """The least p that the exact test of `difference` can give with so many seeds."""
    return 2 / math.comb(x_seeds + y_seeds, x_seeds)


def pooled_difference(x_by_task, y_by_task):
    """@param x_by_task, y_by_task  for each task: seed to score.
    @return (mean over tasks of X less Y over the seeds that both have, how many tasks): of those tasks that
    have `FEWEST` such seeds or more, or where none has, any; resampled in pairs within each task (see
    `matrix`). None where there are fewer than two such tasks."""
    pairs = [[x[seed] - y[seed] for seed in sorted(x.keys() & y.keys())] for x, y in zip(x_by_task, y_by_task)]
    counted = [task for task in pairs if len(task) >= FEWEST] or [task for task in pairs if task]
    return (_estimate(np.mean, matrix(counted)), len(counted)) if len(counted) > 1 else None


def signs(differences):
    """@param differences  of two arms, one each task."""
    better, worse, equal = (int(np.sum(np.sign(np.round(differences, 9)) == sign)) for sign in (1, -1, 0))
    p = scipy.stats.binomtest(better, better + worse).pvalue if better + worse else None
    return Signs(better, worse, equal, p)


def contrast(x, y):
    """@param x, y  values of one group of tasks and of another.
    @return (mean of x less that of y, two-sided p of the permutation test or None where a group is too small)."""
    x, y = np.array(x, dtype=float), np.array(y, dtype=float)
    return float(x.mean() - y.mean()), _permutation_test(x, y)


def _mean_difference(x, y, axis):
    return x.mean(axis=axis) - y.mean(axis=axis)


def _permutation_test(x, y):
    """Of the hypothesis that which arm a run belongs to does not matter. Exact up to `_SPLITS` splits of
    the runs, above that from as many random ones. None where an arm has too few runs."""
    if min(len(x), len(y)) < FEWEST:
        return None
    test = scipy.stats.permutation_test(
        (x, y), _mean_difference, vectorized=True, n_resamples=_SPLITS,
        rng=np.random.default_rng(_SEED))
    return float(test.pvalue)


def trend(levels, values):
    """How clearly values rise with levels: Spearman's rank correlation of two sequences of equal length.
    @return (correlation, two-sided p of the permutation test, exact or from `_SPLITS` random pairings); None
    where either does not vary or fewer than `FEWEST` are given."""
    x, y = (scipy.stats.rankdata(numbers) for numbers in (levels, values))
    if len(x) < FEWEST or np.ptp(x) == 0 or np.ptp(y) == 0:
        return None
    x, y = ((ranks - ranks.mean()) / (ranks.std() * math.sqrt(len(ranks))) for ranks in (x, y))
    test = scipy.stats.permutation_test(
        (x,), lambda paired, axis: (paired * y).sum(axis=axis), vectorized=True,
        permutation_type="pairings", n_resamples=_SPLITS, rng=np.random.default_rng(_SEED))
    return float(test.statistic), float(test.pvalue)
