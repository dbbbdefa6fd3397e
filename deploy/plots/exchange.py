"""The worth of heads to each other: `deploy/exchange`'s evaluations, each head in each block of time."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cells import ResultsError

FOLDER = "exchange"


@dataclass(frozen=True)
class Exchange:
    """One policy of k heads. [k + 1, k] each: head i in block b, the others their own (the policy as it is where
    i = b); in the last row head i in all blocks."""

    success: np.ndarray      # share of episodes, at any step
    success_end: np.ndarray  # at the last step
    returns: np.ndarray      # mean over episodes
    episodes: int            # of each evaluation
    seed: int                # of the placements

    @property
    def heads(self):
        return self.success.shape[1]

    def of_others(self, values):
        """@return (values [k, k - 1]: block b given to each other head, the policy's own value)."""
        others = ~np.eye(self.heads, dtype=bool)
        return values[:-1][others].reshape(self.heads, self.heads - 1), values[0, 0]


def found(results):
    """Task to Exchange of the policies evaluated. @throws ResultsError, also if an order of heads is missing."""
    there = {path.stem: path for path in (Path(results) / FOLDER).glob("*.csv")}
    return {task: read(there[task]) for task in sorted(there)}


def read(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = {tuple(int(head) for head in row["order"].split(",")): row for row in csv.DictReader(file)}
        heads = max(len(order) for order in rows)
        grids = [np.array([[float(rows[_order(block, head, heads)][column]) for head in range(heads)]
                           for block in range(heads + 1)]) for column in ("success", "success_end", "return")]
        any_row = next(iter(rows.values()))
        return Exchange(*grids, int(any_row["episodes"]), int(any_row["seed"]))
    except (KeyError, ValueError, TypeError) as error:
        raise ResultsError(f"{path}: not all that deploy/exchange writes is there ({error}): run it again") from error


def _order(block, head, heads):
    if block == heads:
        return (head,) * heads
    return tuple(head if b == block else b for b in range(heads))
