"""Inputs over time: values that change at communication points, steps and piecewise linear profiles."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from operator import itemgetter
from typing import NamedTuple, Protocol

import numpy as np

from amb_cosim.cosim.basics.time_grid import TimeGrid
from array_types import Array, Indices


class Changes(NamedTuple):
    """Values of positions at communication points, ascending in time; of several at one point, the last one applies."""

    points: Indices
    positions: Indices
    values: Array


class Schedule(Protocol):
    """Inputs over time: writes those that change at communication point n into the array.

    `changes` returns the same as a list, for the points from `first` up to but not including `last`.
    """

    def __call__(self, n: int, exogenous: Array) -> None: ...
    def changes(self, first: int, last: int) -> Changes: ...


class PiecewiseConstant:
    """A schedule of events: from communication point n on, a position has a value."""

    def __init__(self, events: Iterable[tuple[int, int, float]]) -> None:
        ordered = sorted(events, key=itemgetter(0))
        self._points, positions, values = map(list, zip(*ordered, strict=True)) if ordered else ([], [], [])
        self._all = Changes(np.array(self._points, np.intp), np.array(positions, np.intp), np.array(values, np.float64))

    def __call__(self, n: int, exogenous: Array) -> None:
        due = self._due(n, n + 1)
        if due.start < due.stop:
            for position, value in zip(self._all.positions[due], self._all.values[due], strict=True):
                exogenous[position] = value

    def changes(self, first: int, last: int) -> Changes:
        due, (points, positions, values) = self._due(first, last), self._all
        return Changes(points[due], positions[due], values[due])

    def _due(self, first: int, last: int) -> slice:
        return slice(bisect_left(self._points, first), bisect_left(self._points, last))


class PiecewiseLinear:
    """A schedule of a quantity that is linear between points and constant outside, and optionally of its slope.

    Parameters
    ----------
    points
        Communication points and values, ascending.
    grid
        Times of the communication points.
    value, slope
        Positions of the quantity and of its derivative over the coming step, in 1/s.
    """

    def __init__(
        self, points: Sequence[tuple[int, float]], grid: TimeGrid, value: int, slope: int | None = None
    ) -> None:
        self._grid = grid
        self._at = [grid.position(n) for n, _ in points]
        self._values = [value for _, value in points]
        self._value, self._slope = value, slope

    def __call__(self, n: int, exogenous: Array) -> None:
        at = self._grid.position(n)
        after = bisect_right(self._at, at)
        before, after = max(after - 1, 0), min(after, len(self._at) - 1)
        begin, steps = self._at[before], self._at[after] - self._at[before]
        rise = self._values[after] - self._values[before]
        exogenous[self._value] = self._values[before] + (rise * (at - begin) / steps if steps else 0.0)
        if self._slope is not None:
            exogenous[self._slope] = rise / (steps * self._grid.step_size) if steps else 0.0

    def changes(self, first: int, last: int) -> Changes:
        n = np.arange(first, last, dtype=np.intp)
        at, values = np.array(self._at), np.array(self._values)
        place = n.astype(np.float64)
        if self._grid.last is not None:
            place[n == self._grid.last] = self._grid.position(self._grid.last)
        after = np.searchsorted(at, place, side="right")
        before, after = np.maximum(after - 1, 0), np.minimum(after, len(at) - 1)
        steps, rise = at[after] - at[before], values[after] - values[before]
        moving = steps > 0
        part, slope = np.zeros((2, len(n)))
        np.divide(rise * (place - at[before]), steps, out=part, where=moving)
        np.divide(rise, steps * self._grid.step_size, out=slope, where=moving)
        if self._slope is None:
            return Changes(n, np.full(len(n), self._value, np.intp), values[before] + part)
        both = np.column_stack([values[before] + part, slope])
        return Changes(np.repeat(n, 2), np.tile([self._value, self._slope], len(n)), both.ravel())
