"""Conditions that end a run early: a signal has been above or below a limit for long enough.

They are judged at every communication point, with the values that are recorded there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from amb_cosim.cosim.master import Array, IntArray


class Condition(NamedTuple):
    """A signal has been above (or below) a limit for `hold` steps, judged from point `first` on; `text` says it."""

    signal: str
    above: bool
    limit: float
    first: int
    hold: int
    text: str


class Conditions(NamedTuple):
    """Conditions as arrays: met where sign * value > sign * limit at all points from `since` to `since` + `hold`."""

    positions: IntArray
    signs: Array
    limits: Array
    since: IntArray
    hold: IntArray


class Stopped(Exception):
    """The condition with that index is met at that communication point."""

    def __init__(self, index: int, point: int) -> None:
        super().__init__(f"condition {index} is met at point {point}")
        self.index = index
        self.point = point


class Watch:
    """An observer that raises `Stopped` at the first point at which a condition is met.

    `positions` say where the conditions' signals stand in the value array. The compiled loop does the same with the
    arrays `conditions`.
    """

    def __init__(self, conditions: Sequence[Condition] = (), positions: Sequence[int] = ()) -> None:
        self.conditions = Conditions(
            positions=np.array(positions, np.intp),
            signs=np.array([1.0 if c.above else -1.0 for c in conditions], np.float64),
            limits=np.array([c.limit for c in conditions], np.float64),
            since=np.array([c.first for c in conditions], np.intp),
            hold=np.array([c.hold for c in conditions], np.intp),
        )

    def __call__(self, n: int, values: Array) -> None:
        for k, (position, sign, limit, since, hold) in enumerate(zip(*self.conditions, strict=True)):
            if n < since:
                continue
            if not sign * values[position] > sign * limit:
                self.conditions.since[k] = n + 1
            elif n - since >= hold:
                raise Stopped(k, n)
