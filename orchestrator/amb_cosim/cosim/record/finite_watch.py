"""Watches outputs for values that are not finite, at every communication point, recorded or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from array_types import Array, Indices


class NonFinite(NamedTuple):
    """A value that is NaN or infinite, and its communication point."""

    point: int
    value: float


class FiniteWatch:
    """An observer that notes the first NaN and the first infinite value at each chosen position of the value array.

    Parameters
    ----------
    names
        Names of the outputs by position.
    first
        Communication point from which they are watched.
    """

    def __init__(self, names: Mapping[int, str], first: int) -> None:
        self.positions: Indices = np.array([*names], np.intp)
        self.first = first
        self._names = tuple(names.values())
        self.nan: dict[str, NonFinite] = {}
        self.infinite: dict[str, NonFinite] = {}

    def add(self, other: FiniteWatch) -> None:
        """Add the values that another watch has noted; of two values of an output, the earlier one is kept."""
        for firsts, noted in ((self.nan, other.nan), (self.infinite, other.infinite)):
            for name, first in noted.items():
                firsts[name] = min(first, firsts.get(name, first), key=lambda value: value.point)

    def __call__(self, n: int, values: Array) -> None:
        if n >= self.first:
            self.see([n], values[self.positions][None, :])

    def see(self, points: Sequence[int] | Indices, rows: Array) -> None:
        """Check the values at the chosen positions, given in a row for each point, in ascending order."""
        if np.isfinite(rows).all():
            return
        for firsts, mask in ((self.nan, np.isnan(rows)), (self.infinite, np.isinf(rows))):
            for column in np.flatnonzero(mask.any(axis=0)):
                row = int(np.argmax(mask[:, column]))
                first = NonFinite(int(points[row]), float(rows[row, column]))
                name = self._names[column]
                if name not in firsts or first.point < firsts[name].point:
                    firsts[name] = first
