"""Inputs over time: values that change at communication points, by events or along piecewise linear profiles."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from amb_cosim.cosim.grid.time_grid import TimeGrid
from array_types import Array, Indices


class Changes(NamedTuple):
    """Values of inputs, by position, at communication points in ascending order; the last value at a point applies."""

    points: Indices
    positions: Indices
    values: Array


class Schedule:
    """Inputs over time."""

    def changes(self, first: int, last: int) -> Changes:
        """Return the changes at the communication points from `first` up to but not including `last`."""
        raise NotImplementedError

    def __call__(self, n: int, exogenous: Array) -> None:
        """Write the inputs that change at communication point n to the array."""
        _, positions, values = self.changes(n, n + 1)
        exogenous[positions] = values


class PiecewiseConstant(Schedule):
    """A schedule of events: from communication point n on, the input at a position has a new value."""

    def __init__(self, events: Iterable[tuple[int, int, float]]) -> None:
        ordered = sorted(events, key=itemgetter(0))
        self._points, positions, values = map(list, zip(*ordered, strict=True)) if ordered else ([], [], [])
        self._all = Changes(np.array(self._points, np.intp), np.array(positions, np.intp), np.array(values, np.float64))

    def changes(self, first: int, last: int) -> Changes:
        due, changes = slice(bisect_left(self._points, first), bisect_left(self._points, last)), self._all
        return Changes(changes.points[due], changes.positions[due], changes.values[due])


class PiecewiseLinear(Schedule):
    """A schedule of a quantity that is linear between points and constant outside them, and optionally of its slope.

    Parameters
    ----------
    points
        Pairs of communication point and value, in ascending order.
    grid
        Times of the communication points.
    value
        Position of the input that receives the quantity.
    slope
        Position of the input that receives the rate of change of the quantity (per second) over the coming step; None
        if there is no such input.
    """

    def __init__(
        self, points: Sequence[tuple[int, float]], grid: TimeGrid, value: int, slope: int | None = None
    ) -> None:
        self._grid = grid
        self._at = np.array([grid.position(n) for n, _ in points])
        self._values = np.array([value for _, value in points])
        self._value, self._slope = value, slope

    def changes(self, first: int, last: int) -> Changes:
        n = np.arange(first, last, dtype=np.intp)
        at, values = self._at, self._values
        position = n.astype(np.float64)
        if self._grid.last is not None:
            position[n == self._grid.last] = self._grid.position(self._grid.last)
        after = np.searchsorted(at, position, side="right")
        before, after = np.maximum(after - 1, 0), np.minimum(after, len(at) - 1)
        steps, rise = at[after] - at[before], values[after] - values[before]
        moving = steps > 0
        increment, slope = np.zeros((2, len(n)))
        np.divide(rise * (position - at[before]), steps, out=increment, where=moving)
        np.divide(rise, steps * self._grid.step_size, out=slope, where=moving)
        if self._slope is None:
            return Changes(n, np.full(len(n), self._value, np.intp), values[before] + increment)
        both = np.column_stack([values[before] + increment, slope])
        return Changes(np.repeat(n, 2), np.tile([self._value, self._slope], len(n)), both.ravel())
