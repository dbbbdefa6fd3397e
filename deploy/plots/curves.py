"""From the rows of single runs to curves that can be compared and averaged."""

import numpy as np

LAST_UPDATES = 10  # what "at the end of training" averages over
_POINTS = 100
_WINDOW = 0.04  # of a curve's length: what each of its points averages over


def trailing_mean(x, values, grid, width):
    """@param x, values  (rows), x growing.  @return (grid): the mean of the values whose x is in
    (g - width, g], or else of the newest one before g."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    end = np.maximum(np.searchsorted(x, grid, side="right"), 1)
    begin = np.minimum(np.searchsorted(x, grid - width, side="right"), end - 1)
    return (sums[end] - sums[begin]) / (end - begin)


def smooth(tables, column, x="steps"):
    """Brings runs of unequal length and spacing onto one grid, that ends where the shortest run does.
    @return (grid, (runs, grid)): trailing means over 4 % of the grid's length."""
    end = min(table[x][-1] for table in tables)
    points = min(_POINTS, *(int(np.sum(table[x] <= end)) for table in tables))
    grid = np.linspace(end / points, end, points)
    width = _WINDOW * end
    return grid, np.array([trailing_mean(table[x], table[column], grid, width) for table in tables])


def common_rows(tables, column):
    """@return (steps, (runs, steps)): the rows at steps that every run has."""
    steps = tables[0]["steps"]
    for table in tables[1:]:
        steps = np.intersect1d(steps, table["steps"])
    return steps, np.array([table[column][np.isin(table["steps"], steps)] for table in tables])


def at_end(table, column):
    """Mean over the last 10 updates (all, where there are fewer)."""
    return float(table[column][-LAST_UPDATES:].mean())


def noise_average(values):
    """(rows): means over the last 10 updates each; nan where there are not yet 10."""
    count = np.arange(1, len(values) + 1)
    means = trailing_mean(count, values, count, LAST_UPDATES)
    return np.where(count >= min(LAST_UPDATES, len(values)), means, np.nan)


def first_reach(steps, values, threshold):
    """@return the first of `steps` at which the value is `threshold` or more; None if none is."""
    (reached,) = np.nonzero(values >= threshold - 1e-9)
    return float(steps[reached[0]]) if len(reached) else None


def minutes_at(progress, steps):
    """Minutes of wall-clock time that the run had taken at its update at `steps`."""
    row = min(np.searchsorted(progress["steps"], steps), len(progress["steps"]) - 1)
    return float(progress["wall_seconds"][row]) / 60
