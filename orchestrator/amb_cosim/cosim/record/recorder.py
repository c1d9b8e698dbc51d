"""Records chosen signals of a run."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from amb_cosim.cosim.processes.memory import physical_memory
from amb_cosim.cosim.record.step_rows import StepRows, grown
from array_types import Array, Indices

COPIES = 2.0  # of a record at most in memory at a time: itself, and the signals of its result


class RecordBuffer(NamedTuple):
    """Settings of a recorder, and its arrays, to which a compiled loop writes."""

    positions: Indices
    first: int
    every: int
    points: Indices
    table: Array
    steps_positions: Indices
    steps_size: int
    steps_first: int
    steps_table: Array


class Recorder:
    """An observer that stores chosen positions of the value array at every m-th communication point.

    Parameters
    ----------
    positions
        Recorded positions of the value array.
    first
        Communication point at which recording begins.
    every
        Decimation m; points that are multiples of m are recorded.
    each
        Positions that are recorded at every point while the record of the others is decimated.
    rows
        The record of the positions `each`.
    """

    def __init__(
        self,
        positions: Sequence[int],
        first: int,
        every: int = 1,
        each: Sequence[int] = (),
        rows: StepRows | None = None,
    ) -> None:
        self._positions: Indices = np.asarray(positions, dtype=np.intp)
        self.each: Indices = np.asarray(each if every > 1 else (), dtype=np.intp)
        self.step_rows = rows or StepRows(first, ["end"] * len(self.each))
        self._first, self._every = first, every
        self._points = np.zeros(1024, dtype=np.intp)
        self._table = np.zeros((1024, len(positions)))
        self._rows = 0
        self._reached: int | None = None
        self._began = self._latest = 0.0

    def __call__(self, n: int, values: Array) -> None:
        self.see(n)
        if n >= self._first and len(self.each):
            self.step_rows.add(np.take(values, self.each)[None])
        if n >= self._first and n % self._every == 0:
            if self._rows == len(self._points):
                self._grow(2 * self._rows)
            np.take(values, self._positions, out=self._table[self._rows])
            self._points[self._rows] = n
            self._rows += 1

    def restore(self, points: Indices, table: Array) -> None:
        """Load the rows of a continued run: communication points, and a row of values for each."""
        self._rows = 0
        self._grow(len(points))
        self._rows = len(points)
        self._points[: self._rows], self._table[: self._rows] = points, table

    def see(self, n: int) -> None:
        """Update the last point that the run has reached."""
        if n >= 0:
            self._latest = time.perf_counter()
            if self._reached is None:
                self._began = self._latest
            self._reached = n

    def buffer(self, first: int, last: int, may_stop: bool = False) -> RecordBuffer:
        """Return free rows for the points from `first` to `last`; call `fill` with the number of rows used.

        A run that `may_stop` early on a condition may need fewer rows than a run to point `last`.

        Raises
        ------
        ValueError
            If memory does not suffice. Some systems grant more memory than they have, and then kill the process.
        """
        begin = max(first, self._first)
        due = max(0, last // self._every - (begin - 1) // self._every)
        rows, n_steps = self._rows + due, self.step_rows.rows_until(last + 1) if len(self.each) else 0
        size, most = COPIES * 8.0 * (rows * len(self._positions) + n_steps * len(self.each)), physical_memory()
        if size > most and not may_stop:
            every_step = f", plus {len(self.each)} of them at {n_steps} steps," if len(self.each) else ""
            raise ValueError(
                f"the record of {len(self._positions)} variables at {rows} points{every_step} needs {size / 1e9:.3g} "
                f"GB of memory, and this machine has {most / 1e9:.3g} GB; to reduce the record, set fewer "
                "record.variables or a shorter end_time in the scenario"
            )
        try:
            self._grow(rows)
            of_steps = self.step_rows.reserve(last + 1 if len(self.each) else 0)
        except (MemoryError, ValueError) as error:  # numpy raises either
            raise ValueError(
                f"there is not enough memory to record {len(self._positions)} variables at {due} points; record "
                f"fewer by setting record.variables or record.every in the scenario"
            ) from error
        table = self._positions, self._first, self._every, self._points, self._table
        return RecordBuffer(*table, self.each, len(self.each), *of_steps)

    def fill(self, rows: int, reached: int) -> None:
        """Set the number of rows that are in use after the points up to `reached`."""
        self._rows = rows
        if len(self.each):
            self.step_rows.wrote(reached + 1)

    def _grow(self, rows: int) -> None:
        """Make room for this number of rows; memory pages are allocated when they are written to."""
        self._points, self._table = grown(self._points, self._rows, rows), grown(self._table, self._rows, rows)

    def __getstate__(self) -> dict[str, object]:
        """Return the state without unused rows, which another process does not need."""
        return self.__dict__ | {"_points": self.points, "_table": self.table}

    @property
    def points(self) -> Indices:
        """Communication points recorded so far."""
        return self._points[: self._rows]

    @property
    def table(self) -> Array:
        """Values recorded so far, a row for each of `points`."""
        return self._table[: self._rows]

    @property
    def reached(self) -> int:
        """Last communication point seen; 0 during settling."""
        return self._reached or 0

    @property
    def wall_time(self) -> float:
        """Wall-clock time from point 0 to the last point seen (s)."""
        return self._latest - self._began
