"""Differences between two records of a signal."""

from __future__ import annotations

import math

import numpy as np

from array_types import Array

TURN = 2.0 * math.pi


def differences(values: Array, reference: Array, unit: str | None) -> Array:
    """Return the absolute differences of values from a reference of the same shape, in their unit.

    An angle (rad) that stays within a turn in both records starts again at its end, so that 0.01 and 6.27 are
    neighbours: d = min(|a - b|, |2 pi - |a - b||).
    """
    result = np.abs(values - reference)
    if unit == "rad" and result.size and max(np.ptp(values), np.ptp(reference)) <= TURN:
        return np.asarray(np.minimum(result, np.abs(TURN - result)))
    return np.asarray(result)
