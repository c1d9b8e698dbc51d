"""Rows of values at every step or, in long runs, for several steps together.

A row of k steps ends at a point that is a multiple of k. For each variable it contains the value that a communication
step of that length would have: the value at its end, or the largest value, the sum or the mean over its steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from array_types import Array, Indices
from fmi_export.variables import OverStep

MOST_ROWS = 2_000_000  # in a run whose rows can be shorter than `LONGEST_ROW`
LONGEST_ROW = 0.5e-3  # s, half of the window over which contact forces are averaged


def steps_in_row(n_steps: int, every: int, step_size: float) -> int:
    """Return the steps per row: the smallest divisor of `every` that gives at most `MOST_ROWS` rows.

    A row is at most `LONGEST_ROW` long. If this requires more rows, the largest divisor that it allows is returned.

    Parameters
    ----------
    n_steps
        Steps of the run.
    every
        Number of steps between samples of the decimated record; the length of a row divides it, so samples coincide
        with ends of rows.
    step_size
        Length of a step (s).
    """
    longest = max(1, math.floor(LONGEST_ROW / step_size * (1.0 + 1e-9)))
    allowed = [k for k in range(1, min(longest, every) + 1) if every % k == 0]
    return next((k for k in allowed if n_steps <= k * MOST_ROWS), allowed[-1])


def complete_rows(first: int, end: int, steps: int) -> tuple[int, int]:
    """Return the number of complete rows from point `first` to point `end` - 1, and the number of points after them."""
    if end <= first:
        return 0, 0
    rows = (end - 1) // steps - (first - 1) // steps
    return rows, (end - 1) % steps if rows else end - first


A = TypeVar("A", Array, Indices)


def grown(items: A, used: int, rows: int) -> A:
    """Return an array that begins with the used rows and has room for `rows` rows; it may be `items` itself."""
    if rows <= len(items):
        return items
    result = np.zeros((rows, *items.shape[1:]), items.dtype)
    result[:used] = items[:used]
    return result


class StepRows:
    """A growing table of rows.

    Parameters
    ----------
    first
        First recorded communication point.
    rules
        How each column summarises a step.
    steps
        Number of steps in a row.
    """

    def __init__(self, first: int, rules: Sequence[OverStep] = (), steps: int = 1) -> None:
        self.steps = steps
        self._first = self._next = first
        self._rules = tuple(rules)
        self._table = np.zeros((0, len(rules)))
        self._n = 0
        self._rest = np.zeros((0, len(rules)))  # values at the points after the last complete row

    def reserve(self, end: int) -> tuple[int, Array]:
        """Make room for the rows up to point `end` - 1; return the point of the first row and the table.

        If each row contains one step, values may be written to the table; call `wrote` afterwards. Memory pages are
        allocated when they are written to.
        """
        self._table = grown(self._table, self._n, self.rows_until(end))
        return self._first, self._table

    def rows_until(self, end: int) -> int:
        """Return the number of complete rows up to point `end` - 1."""
        return complete_rows(self._first, end, self.steps)[0]

    def wrote(self, end: int) -> None:
        """Extend the used part of the table to the point `end` - 1."""
        if end > self._next:
            self._n += end - self._next
            self._next = end

    def add(self, values: Array) -> None:
        """Add the values at the next points, shape (points, columns)."""
        begin, self._next = self._next - len(self._rest), self._next + len(values)
        values = np.concatenate([self._rest, values])
        rows, left = complete_rows(begin, self._next, self.steps)
        if self._n + rows > len(self._table):
            self._table = grown(self._table, self._n, max(self._n + rows, 1024, 2 * self._n))
        complete = len(values) - left
        if rows:
            self._table[self._n : self._n + rows] = self._combined(begin, values[:complete])
        self._n, self._rest = self._n + rows, values[complete:].copy()

    def restore(self, end: int, table: Array, rest: Array, steps: int) -> None:
        """Load the rows of a continued run up to point `end` - 1."""
        self._next, self._table, self._n, self._rest, self.steps = max(end, self._first), table, len(table), rest, steps

    @property
    def complete(self) -> Array:
        """The complete rows."""
        return self._table[: self._n]

    @property
    def rest(self) -> Array:
        """Values at the points after the last complete row."""
        return self._rest

    @property
    def values(self) -> Array:
        """All rows; the last one may have fewer steps than the others."""
        if not len(self._rest):
            return self.complete
        return np.concatenate([self.complete, self._combined(self._next - len(self._rest), self._rest)])

    @property
    def points(self) -> Indices:
        """The communication points at which rows end."""
        ends = self.steps * (-(-self._first // self.steps) + np.arange(self._n))
        return np.append(ends, [self._next - 1] * min(1, len(self._rest))).astype(np.intp)

    def _combined(self, first: int, values: Array) -> Array:
        """Return rows of the values at the points from `first` on; the last one may be incomplete."""
        if self.steps == 1:
            return values
        row = -(-(first + np.arange(len(values))) // self.steps)
        begins = np.flatnonzero(np.diff(row, prepend=row[0] - 1))
        sizes = np.diff(np.append(begins, len(values)))
        result = values[begins + sizes - 1]
        for k, rule in enumerate(self._rules):
            if rule == "largest":
                result[:, k] = np.maximum.reduceat(values[:, k], begins)
            elif rule != "end":
                result[:, k] = np.add.reduceat(values[:, k], begins) / (sizes if rule == "mean" else 1)
        return result

    def __getstate__(self) -> dict[str, object]:
        """Return the state without unused rows, which another process does not need."""
        return self.__dict__ | {"_table": self.complete}
