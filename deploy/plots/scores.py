"""The scores by which runs are compared."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import curves
import estimates
from cells import Cell


def _last_evaluation(column):
    def score(cell):
        table = cell.evaluations.get("random")
        value = float(table[column][-1]) if table else math.nan
        return value if math.isfinite(value) else None

    return score


@dataclass(frozen=True)
class Score:
    label: str
    of: Callable[[Cell], float | None]  # None where the run does not have it
    share: bool  # between 0 and 1; otherwise a return


RETURN = Score("average return", lambda cell: curves.at_end(cell.progress, "return"), False)
SUCCESS = Score("success under noise", lambda cell: curves.at_end(cell.progress, "success"), True)
SUCCESS_END = Score("success at the last step, under noise",
                    lambda cell: curves.at_end(cell.progress, "success_end"), True)
DETERMINISTIC = Score("deterministic success", _last_evaluation("success"), True)
DETERMINISTIC_END = Score("deterministic success at the last step",
                          _last_evaluation("success_end"), True)
DETERMINISTIC_200 = Score("deterministic success by step 200", _last_evaluation("success_200"), True)
DETERMINISTIC_RETURN = Score("deterministic return", _last_evaluation("return"), False)
COMPARED = (RETURN, SUCCESS, DETERMINISTIC)  # of arms, where a figure or table has room for few
NORMALISED = Score("normalised return",
                   lambda cell: RETURN.of(cell) / cell.largest_return, True)


def _deterministic_normalised(cell):
    value = DETERMINISTIC_RETURN.of(cell)
    return None if value is None else value / cell.largest_return


DETERMINISTIC_NORMALISED = Score("deterministic normalised return", _deterministic_normalised, True)


def select(cells, task=None, arm=None):
    return [cell for cell in cells if task in (None, cell.task) and arm in (None, cell.arm)]


def by_seed(cells, score):
    """@return seed to score, of those runs that have it. `cells` are of one task and arm."""
    found = {cell.seed: score.of(cell) for cell in cells}
    return {seed: value for seed, value in found.items() if value is not None}


def by_task(cells, arm, tasks, score):
    """@return a list of scores for each task."""
    return [list(by_seed(select(cells, task, arm), score).values()) for task in tasks]


def shared_tasks(cells, tasks, arms, score):
    """The tasks that can be averaged over and still be compared: those of which every arm has enough runs for an
    interval, or where there are none, any runs."""
    fewest = {task: min(len(by_seed(select(cells, task, arm), score)) for arm in arms) for task in tasks}
    return ([task for task in tasks if fewest[task] >= estimates.FEWEST]
            or [task for task in tasks if fewest[task] > 0])


def seeds_text(counts):
    """5, or 3 to 5."""
    low, high = min(counts), max(counts)
    return str(low) if low == high else f"{low} to {high}"
