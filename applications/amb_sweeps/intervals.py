"""Intervals of probabilities and quantiles that follow from independent runs (scipy.stats).

Of n runs, k have an outcome, and u have no outcome yet. Clopper and Pearson (Biometrika 26, 1934) give

    low = B^-1(a/2; k, n - k + 1),     high = B^-1(1 - a/2; k + u + 1, n - k - u)                             (1)

where B^-1 is the quantile of the beta distribution and 1 - a the confidence. The runs without an outcome widen the
interval at both ends: for `low` none of them has the outcome, for `high` all have it.

The quantile of order q lies between two of the sorted values, with

    P(Bin(n, q) <= r - 1) <= a/2,     P(Bin(n, q) <= s - 1) >= 1 - a/2,                                       (2)

for the largest r and the smallest s, whatever the distribution (David and Nagaraja, Order Statistics, 2003).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """An estimate and its bounds; a bound is None if it needs more values."""

    value: float
    low: float | None
    high: float | None


def probability(count: int, runs: int, undecided: int = 0, confidence: float = CONFIDENCE) -> Interval:
    """Return the probability of an outcome by (1); its value is the share of the decided runs.

    If none or all of the runs have the outcome, the interval has a single bound.

    Raises
    ------
    ValueError
        If no run has ended, or the counts exceed the number of runs.
    """
    from scipy.stats import binomtest

    if not (runs >= 1 and count >= 0 and undecided >= 0 and count + undecided <= runs):
        raise ValueError(
            f"{count} runs with and {undecided} without an outcome, of {runs}, are not allowed; "
            "counts must be 0 or more, and not exceed the number of runs, which must be 1 or more"
        )
    if count == 0 and not undecided:
        return Interval(0.0, 0.0, float(binomtest(0, runs, alternative="less").proportion_ci(confidence).high))
    if count == runs:
        return Interval(1.0, float(binomtest(runs, runs, alternative="greater").proportion_ci(confidence).low), 1.0)
    low = float(binomtest(count, runs).proportion_ci(confidence).low)
    high = float(binomtest(count + undecided, runs).proportion_ci(confidence).high)
    decided = runs - undecided
    return Interval(count / decided if decided else math.nan, low, high)


def quantile(values: NDArray[np.float64], order: float, confidence: float = CONFIDENCE) -> Interval:
    """Return a quantile of at least one independent value, by (2)."""
    from scipy.stats import binom

    ordered, tail = np.sort(values), 0.5 * (1.0 - confidence)
    first = int(binom.ppf(tail, len(values), order))  # r
    last = int(binom.ppf(1.0 - tail, len(values), order)) + 1  # s
    return Interval(
        float(np.quantile(ordered, order)),
        float(ordered[first - 1]) if first >= 1 else None,
        float(ordered[last - 1]) if last <= len(values) else None,
    )


def runs_for_bounds(order: float, confidence: float = CONFIDENCE) -> int:
    """Return the least number of values with which a quantile has both bounds."""
    return math.ceil(math.log(0.5 * (1.0 - confidence)) / math.log(max(order, 1.0 - order)))
