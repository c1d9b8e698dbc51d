"""Keeps what a run produces, as far as it comes."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from orchestrator.master import Array, IntArray


class Recorder:
    """An observer that stores chosen positions of the value array at every m-th communication point.

    Parameters
    ----------
    positions
        Which positions of the value array are kept.
    first
        Communication point at which recording begins.
    every
        Decimation m; points that are multiples of it are kept.
    """

    def __init__(self, positions: Sequence[int], first: int, every: int = 1) -> None:
        self._positions: IntArray = np.asarray(positions, dtype=np.intp)
        self._first, self._every = first, every
        self._points = np.zeros(1024, dtype=np.intp)
        self._table = np.zeros((1024, len(positions)))
        self._rows = 0
        self._reached: int | None = None
        self._began = self._latest = 0.0

    def __call__(self, n: int, values: Array) -> None:
        if n >= 0:
            self._latest = time.perf_counter()
            if self._reached is None:
                self._began = self._latest
            self._reached = n
        if n >= self._first and n % self._every == 0:
            if self._rows == len(self._points):
                self._points = np.concatenate([self._points, np.zeros_like(self._points)])
                self._table = np.concatenate([self._table, np.zeros_like(self._table)])
            np.take(values, self._positions, out=self._table[self._rows])
            self._points[self._rows] = n
            self._rows += 1

    @property
    def points(self) -> IntArray:
        """Communication points recorded so far."""
        return self._points[: self._rows]

    @property
    def table(self) -> Array:
        """Values recorded so far, one row for each of `points`."""
        return self._table[: self._rows]

    @property
    def reached(self) -> int:
        """Last communication point seen, 0 if the run has not left settling."""
        return self._reached or 0

    @property
    def wall_time(self) -> float:
        """Wall-clock time from point 0 to the last point seen, in s."""
        return self._latest - self._began
