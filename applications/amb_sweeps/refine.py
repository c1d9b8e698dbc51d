"""Bisects the boundary between two outcomes along the axes of a grid.

If neighbours on the grid differ in a metric that is 0 or 1, the point half-way between them is run. Of the two halves
of the interval, the one whose ends differ is kept. This is repeated until the interval is shorter than the tolerance.
Each round halves all intervals, so spacing / tolerance = 2^n takes n rounds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from amb_sweeps.axes import Axis, Column
from amb_sweeps.sampling import POINT, SamplePlan

if TYPE_CHECKING:
    import xarray as xr

    from amb_sweeps.store import SweepStore

BOUNDARIES = ("recovered", "contact", "rolling")


def boundary_group(metric: str) -> str:
    """Return the name of the store's group that contains the boundary of a metric."""
    return f"boundary_{metric}"


@dataclass
class Interval:
    """An interval between grid neighbours whose outcomes differ: axis, grid indices, ends, and value at the low end."""

    axis: int
    index: tuple[int, ...]
    low: float
    high: float
    value_at_low: float

    @property
    def middle(self) -> float:
        """Fractional index half-way."""
        return 0.5 * (self.low + self.high)


class Refinement:
    """The intervals that the boundary crosses, which are halved in each round.

    Parameters
    ----------
    design, results
        A grid and its results.
    tolerance
        Length, as a fraction of the axis, below which an interval is not halved further.
    metric
        The metric whose boundary is located; its values are 0 and 1.
    """

    def __init__(self, design: SamplePlan, results: xr.Dataset, tolerance: float, metric: str) -> None:
        self.design, self.metric, self.tolerance = design, metric, tolerance
        self.intervals = _crossed(design, np.asarray(results[metric].values, np.float64))
        self.rounds = self.runs = 0
        self._halved: list[Interval] = []

    def next_round(self) -> SamplePlan | None:
        """Return the points of the next round, or None if every interval is short enough."""
        self._halved = [i for i in self.intervals if i.high - i.low > self.tolerance * (self.design.shape[i.axis] - 1)]
        if not self._halved:
            return None
        self.rounds += 1
        self.runs += len(self._halved)
        rows = [self._place(interval, interval.middle) for interval in self._halved]
        settings = tuple(self._settings(interval) for interval in self._halved)
        columns = [
            Column(c.name, tuple(row[c.name] for row in rows), c.unit) for a in self.design.axes for c in a.columns
        ]
        return SamplePlan((Axis(POINT, tuple(columns), settings),), f"round {self.rounds}")

    def learn(self, results: xr.Dataset) -> None:
        """Replace each interval by the half whose ends differ; drop intervals without an outcome in the middle."""
        for interval, value in zip(self._halved, results[self.metric].values, strict=True):
            if math.isnan(value):
                self.intervals.remove(interval)
            elif value == interval.value_at_low:
                interval.low = interval.middle
            else:
                interval.high = interval.middle

    def boundary(self) -> xr.Dataset:
        """Return the points of the boundary: the middles of the intervals, with their axis and length."""
        import xarray as xr

        rows = [self._place(interval, interval.middle) for interval in self.intervals]
        data = {
            c.name: (POINT, np.array([row[c.name] for row in rows]), {"units": c.unit} if c.unit else {})
            for axis in self.design.axes
            for c in axis.columns
        }
        along = [self.design.axes[i.axis].name for i in self.intervals]
        width = [self._width(i) for i in self.intervals]
        result = {"along": (POINT, np.array(along, "<U80")), "uncertainty": (POINT, np.array(width, np.float64))}
        return xr.Dataset({**data, **result}, attrs=self._attributes())

    def _attributes(self) -> dict[str, Any]:
        return {"metric": self.metric, "tolerance": self.tolerance, "rounds": self.rounds, "runs": self.runs}

    def save(self, store: SweepStore) -> None:
        """Write the boundary as a group of the store."""
        store.replace_group(boundary_group(self.metric), self.boundary())

    def _place(self, interval: Interval, at: float) -> dict[str, Any]:
        """Return the coordinates of a point on the line along which an interval lies."""
        row: dict[str, Any] = {}
        for k, axis in enumerate(self.design.axes):
            for column in axis.columns:
                if k == interval.axis:
                    row[column.name] = float(np.interp(at, range(len(axis)), column.values))  # type: ignore[arg-type]
                else:
                    row[column.name] = column.values[interval.index[k]]
        return row

    def _settings(self, interval: Interval) -> Mapping[str, Any]:
        merged: dict[str, Any] = {}
        place = self._place(interval, interval.middle)
        for k, axis in enumerate(self.design.axes):
            if k == interval.axis:
                merged |= {c.name: Column(c.name, (place[c.name],), c.unit).setting(0) for c in axis.columns}
            else:
                merged |= axis.settings(interval.index[k])
        return merged

    def _width(self, interval: Interval) -> float:
        """Return half the length of an interval, in the unit of its axis."""
        column = self.design.axes[interval.axis].columns[0]
        ends = np.interp([interval.low, interval.high], range(len(column.values)), column.values)  # type: ignore[arg-type]
        return float(0.5 * abs(ends[1] - ends[0]))


def check_refinement(design: SamplePlan, tolerance: float, metric: str) -> None:
    """Raise ValueError if a sweep cannot be refined to a tolerance at the boundary of a metric."""
    if not 1e-6 <= tolerance < 1.0:
        raise ValueError(
            f"certainty = {tolerance:g} is not allowed; it must be >= 1e-06 and < 1, as a fraction of an axis"
        )
    if not refined_axes(design):
        raise ValueError(
            f"sample = 'boundary:{metric}' is not allowed; it needs an axis with two or more numbers in ascending order"
        )


def refined_axes(design: SamplePlan) -> list[Axis]:
    """Return the numeric axes with ascending values, between which further points can lie."""
    return [axis for axis in design.axes if _is_ordered(axis)]


def _is_ordered(axis: Axis) -> bool:
    if axis.alternatives or len(axis) < 2 or not all(column.numeric for column in axis.columns):
        return False
    return bool(np.all(np.diff(np.asarray(axis.columns[0].values, np.float64)) > 0.0))


def _crossed(design: SamplePlan, values: np.ndarray[Any, Any]) -> list[Interval]:
    """Return the intervals between neighbours that differ; neighbours without an outcome are left out."""
    result = []
    for k, axis in enumerate(design.axes):
        if not _is_ordered(axis):
            continue
        lower, upper = (np.take(values, range(*ends), axis=k) for ends in ((0, len(axis) - 1), (1, len(axis))))
        for index in np.argwhere((lower != upper) & ~np.isnan(lower) & ~np.isnan(upper)):
            at = tuple(int(i) for i in index)
            result.append(Interval(k, at, float(at[k]), at[k] + 1.0, float(lower[at])))
    return result
