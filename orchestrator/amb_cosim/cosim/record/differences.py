"""Differences between two records of a signal."""

from __future__ import annotations

import math

import numpy as np

from array_types import Array

TURNS = {"rad": 2.0 * math.pi, "deg": 360.0}


def differences(values: Array, reference: Array, unit: str | None) -> Array:
    """Return the absolute differences of values from a reference of the same shape, in their unit.

    An angle that stays within a turn in both records starts again at the end of the turn, so 0.01 and 6.27 rad are
    neighbours: d = min(|a - b|, |2 pi - |a - b||). An angle that counts turns is an ordinary number.
    """
    result: Array = np.abs(values - reference)
    turn = TURNS.get(unit or "", 0.0)
    if result.size and max(np.ptp(values), np.ptp(reference)) <= turn:
        result = np.minimum(result, np.abs(turn - result))
    return result
