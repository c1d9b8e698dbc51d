"""Chooses the next points of a sweep, to locate a maximum or a boundary without running all points.

A Gaussian process fitted to the finished points has mean m and standard deviation s at the others. The next point
maximises

    maximum of y:        m + 2 s - max y                                                             (1)
    boundary y = level:  2 s - |m - level|                                                           (2)

and the search ends when this is nowhere more than `certainty` times the range of y so far: N. Srinivas, A.
Krause, S. Kakade, M. Seeger, IEEE Trans. Information Theory 58 (2012) 3250-3265; for (2) B. Bryan et al., Active
learning for identifying function threshold boundaries, Advances in Neural Information Processing Systems 18 (2005).
Running points are taken to result in the mean.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.sweeps.axes import is_phase
from amb_cosim.sweeps.metrics import UNITS
from amb_cosim.sweeps.panels import numeric_axes, panels, value_text
from amb_cosim.sweeps.sampling import SAMPLE, SamplePlan
from amb_cosim.sweeps.surrogate import Surrogate, coordinates
from amb_cosim.sweeps.worker import PointResult
from amb_files.suggestions import suggest
from array_types import Array

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("maximum", "minimum", "boundary")
WIDTH = 2.0  # standard deviations
MOST = 50_000  # most candidate points
PERIODS = {"deg": 360.0, "rad": 2.0 * math.pi}
PER_AXIS, AT_LEAST = 5, 2  # initial points: per axis, plus a constant
CHECKS = 2  # additional points per axis whose spacing the finished points must reach


@dataclass(frozen=True)
class Goal:
    """Goal of a search: `maximum`, `minimum` or `boundary` of a metric, the level of a boundary, and the certainty.

    `certainty` is the remaining uncertainty as a fraction of the range of values.
    """

    kind: str
    metric: str
    level: float = 0.5
    certainty: float = 0.01

    @property
    def group(self) -> str:
        """The group of the store with the results of the search."""
        return f"{self.kind}_{self.metric}"


def read_goal(text: str, certainty: float, has_user_metrics: bool = False) -> Goal:
    """Read `maximum:METRIC`, `minimum:METRIC`, `boundary:METRIC` or `boundary:METRIC=LEVEL`.

    Raises
    ------
    ValueError
        If the text, the metric or the certainty is invalid.
    """
    match = re.fullmatch(r"(\w+):([\w.]+?)(?:=([-+.\deE]+))?", text.strip())
    if match is None or match[1] not in KINDS or (match[3] and match[1] != "boundary"):
        allowed = "maximum:METRIC, minimum:METRIC, boundary:METRIC or boundary:METRIC=LEVEL"
        raise ValueError(f"--adaptive {text} is not allowed; it must be {allowed}")
    try:
        level = float(match[3] or 0.5)
    except ValueError:
        level = math.nan
    if not math.isfinite(level):
        raise ValueError(f"--adaptive {text}: a level of {match[3]} is not allowed; it must be a finite number")
    if not has_user_metrics and match[2].partition(".")[0] not in UNITS:
        raise ValueError(f"--adaptive {text}: no metric {match[2]!r}; {suggest(match[2], list(UNITS))}")
    if not 1e-6 <= certainty < 1.0:
        raise ValueError(
            f"--certainty {certainty:g} is not allowed; it must be >= 1e-06 and < 1, a fraction of the range"
        )
    return Goal(match[1], match[2], level, certainty)


@dataclass(eq=False)
class _AlternativePoints:
    """The points of an alternative: their indices, coordinates, and the axis of each coordinate."""

    title: str
    points: NDArray[np.int64]
    at: Array
    axis: tuple[int, ...]
    promise: float = math.inf  # the largest expected gain (1) or (2), by the last fit
    surrogate: Surrogate | None = None
    fitted: int = 0  # number of values to which the surrogate's lengths were fitted
    first: list[int] = field(default_factory=list)
    reach: float = 0.0  # largest allowed distance of a point from all finished ones


class Sampler:
    """Chooses points of a design.

    Parameters
    ----------
    design
        Points to choose from: a grid or a sample.
    goal
        Goal, in each alternative separately.
    dataset
        Results so far, if any.

    Raises
    ------
    ValueError
        If no axis has numbers, or there are too many points.
    """

    def __init__(self, design: SamplePlan, goal: Goal, dataset: xr.Dataset | None = None) -> None:
        if design.size > MOST:
            raise ValueError(f"{design.size} points are not allowed with --adaptive; it takes {MOST} at most")
        across = numeric_axes(design)
        if not across:
            raise ValueError("--adaptive needs an axis with two numbers or more")
        self.design, self.goal = design, goal
        self._values = np.full(design.size, np.nan)
        self._done = np.zeros(design.size, bool)
        if dataset is not None:
            self._done |= (dataset["outcome"].values != "").ravel()
            if goal.metric in dataset:
                metric = dataset[goal.metric].values.ravel()
                self._values[:] = np.where(np.isfinite(metric), metric, np.nan)
        self.periodic: list[str] = []
        values, periods = self._axes(across)
        numbers = np.arange(design.size).reshape(design.shape)
        self._parts = []
        for panel in panels(design, across):
            index = tuple(panel.at.get(axis.name, slice(None)) for axis in design.axes)
            points = numbers[index].ravel()
            at, axis = coordinates([v[points] for v in values], periods)
            part = _AlternativePoints(panel.title, points, at, axis)
            first, whole = (min(len(points), AT_LEAST + n * len(values)) for n in (PER_AXIS, PER_AXIS + CHECKS))
            order = _spread(at, whole)
            part.first = [int(points[k]) for k in order[:first]]
            part.reach = float(_distance(at, order).max()) * (1.0 + 1e-9)
            self._parts.append(part)

    def _axes(self, across: Collection[str]) -> tuple[list[Array], list[float | None]]:
        """Return the values of all numeric variations at all points, and their periods."""
        values: list[Array] = []
        periods: list[float | None] = []
        for k, axis in enumerate(self.design.axes):
            if axis.name not in across:
                continue
            for column in axis.columns if axis.name == SAMPLE else axis.columns[:1]:
                settings = np.asarray(column.values, np.float64)
                shape = [-1 if j == k else 1 for j in range(len(self.design.axes))]
                values.append(np.broadcast_to(settings.reshape(shape), self.design.shape).ravel())
                period = 1.0 if is_phase(column.name) else PERIODS.get(column.unit)
                if period is not None and not 0.5 < np.ptp(settings) / period < 1.0 + 1e-9:
                    period = None  # more than a turn, or too little to decide
                periods.append(period)
                if period is not None:
                    self.periodic.append(column.name)
        return values, periods

    def learn(self, results: Iterable[PointResult]) -> None:
        """Add the results of points.

        Raises
        ------
        ValueError
            If the runs have no such metric.
        """
        for result in results:
            if result.metrics and self.goal.metric not in result.metrics:
                raise ValueError(f"no metric {self.goal.metric!r}; {suggest(self.goal.metric, list(result.metrics))}")
            self._done[result.point] = True
            self._values[result.point] = result.metrics.get(self.goal.metric, math.nan)
        self._values[~np.isfinite(self._values)] = np.nan  # an infinite metric is no value to seek from

    def next_points(self, count: int, pending: Collection[int] = ()) -> tuple[list[int], bool]:
        """Return up to `count` points to run next, given the running ones, and whether the goal is reached."""
        done, values = self._done.copy(), self._values.copy()  # results may arrive during this call
        result: list[int] = []
        is_open = False
        for k, part in enumerate(self._parts):
            share = -(-(count - len(result)) // (len(self._parts) - k))
            requested = self._of_part(part, share, done, values, set(pending))
            is_open = is_open or bool(requested) or not set(pending).isdisjoint(part.points.tolist())
            result += requested
        return result, not is_open

    def _of_part(self, part: _AlternativePoints, count: int, done: Any, values: Array, pending: set[int]) -> list[int]:
        """Return the next points of a part, and update its fit."""
        missing = [n for n in part.first if not done[n] and n not in pending]
        is_finished = done[part.points] & np.isfinite(values[part.points])
        available, y = part.at[is_finished], values[part.points][is_finished]
        waits = np.isin(part.points, list(pending))
        closed = done[part.points] | waits
        if missing or len(y) < min(len(part.first), AT_LEAST + 1) or not np.ptp(y):
            return missing[:count] if missing else self._blind(part, count, closed)
        if part.surrogate is None or len(y) > 1.1 * part.fitted:
            part.surrogate, part.fitted = Surrogate(available, part.axis, y), len(y)
        surrogate = part.surrogate.with_values(available, y)
        threshold = self.goal.certainty * float(np.ptp(y))
        part.promise = float(self._promise(surrogate, part.at[~done[part.points]], y).max(initial=0.0))
        surrogate = surrogate.believing(part.at[waits])
        requested: list[int] = []
        while len(requested) < count and not closed.all():
            promise = np.where(closed, -np.inf, self._promise(surrogate, part.at, y))
            best = int(promise.argmax())
            if promise[best] <= threshold:
                break
            requested.append(int(part.points[best]))
            closed[best] = True
            if len(requested) < count:
                surrogate = surrogate.believing(part.at[[best]])
        if not requested and _distance(part.at, np.flatnonzero(closed)).max() > part.reach:
            return self._far(part, 1, closed)
        return requested

    def _blind(self, part: _AlternativePoints, count: int, closed: Any) -> list[int]:
        """Return points far from all others while the finished ones have no values; a few times the initial number."""
        part.promise = 0.0
        left = min(4 * len(part.first), len(closed)) - int(closed.sum())
        return self._far(part, min(count, left), closed) if left > 0 else []

    def _far(self, part: _AlternativePoints, count: int, closed: Any) -> list[int]:
        """Return points far from all finished and running ones."""
        order = _spread(part.at, min(int(closed.sum()) + count, len(closed)), np.flatnonzero(closed))
        return [int(part.points[k]) for k in order[int(closed.sum()) :]]

    def _promise(self, surrogate: Surrogate, at: Array, y: Array) -> Array:
        """Return (1) or (2) at points."""
        if not len(at):
            return np.zeros(0)
        mean, deviation = surrogate.at(at)
        if self.goal.kind == "boundary":
            return WIDTH * deviation - np.abs(mean - self.goal.level)
        sign = 1.0 if self.goal.kind == "maximum" else -1.0
        return sign * mean + WIDTH * deviation - float((sign * y).max())

    @property
    def promise(self) -> float:
        """The largest (1) or (2) of all points that were not run."""
        return max(part.promise for part in self._parts)

    def summary_lines(self) -> list[str]:
        """Return the result of the search, one line per alternative."""
        return [f"{part.title + ': ' if part.title else ''}{self._summary(part)}" for part in self._parts]

    def _summary(self, part: _AlternativePoints) -> str:
        goal, values = self.goal, self._values[part.points]
        runs = f"by {int(self._done[part.points].sum())} of {len(values)} runs"
        runs += f"; {', '.join(self.periodic)} is taken as periodic" if self.periodic else ""
        if not np.isfinite(values).any():
            return f"no {goal.kind} of {goal.metric} {runs}: none has a value"
        unit = UNITS.get(goal.metric.partition(".")[0], "")
        unit = "" if unit in ("", "1") else f" {unit}"
        if goal.kind == "boundary":
            within = f"to within {part.promise:.2g}{unit} at {WIDTH:g} standard deviations"
            return f"boundary of {goal.metric} at {goal.level:g}{unit}, {within}, {runs}"
        best = int(np.nanargmax(values) if goal.kind == "maximum" else np.nanargmin(values))
        where = ", ".join(_where(self.design, int(part.points[best])))
        within = f"elsewhere {part.promise:.2g}{unit} {'more' if goal.kind == 'maximum' else 'less'} at most"
        return (
            f"{goal.kind} of {goal.metric}: {values[best]:.5g}{unit} with {where}; {within}, at {WIDTH:g} standard "
            f"deviations, {runs}"
        )

    def dataset(self) -> xr.Dataset:
        """Return mean and standard deviation of the metric at all points, and the result as text."""
        import xarray as xr

        mean, deviation = np.full((2, self.design.size), np.nan)
        for part in self._parts:
            if part.surrogate is not None:
                is_finished = np.isfinite(self._values[part.points])
                whole = part.surrogate.with_values(part.at[is_finished], self._values[part.points][is_finished])
                mean[part.points], deviation[part.points] = whole.at(part.at)
        dims = tuple(axis.name for axis in self.design.axes)
        result = {"mean": mean, "deviation": deviation}
        data = {name: (dims, values.reshape(self.design.shape)) for name, values in result.items()}
        facts = {"goal": self.goal.kind, "metric": self.goal.metric, "certainty": self.goal.certainty}
        return xr.Dataset(data, attrs={**facts, "told": "\n".join(self.summary_lines())})


def _spread(at: Array, count: int, first: Sequence[int] | NDArray[Any] = ()) -> list[int]:
    """Return `count` points, beginning with the given ones; each is as far as possible from those before it."""
    chosen = [int(k) for k in first] or [int(np.linalg.norm(at - at.mean(axis=0), axis=1).argmin())]
    distance = _distance(at, chosen)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(at - at[chosen[-1]], axis=1))
    return chosen


def _distance(at: Array, chosen: Sequence[int] | NDArray[Any]) -> Array:
    """Return the distance of each point to the nearest chosen one."""
    return np.asarray(np.min([np.linalg.norm(at - at[k], axis=1) for k in chosen], axis=0))


def _where(design: SamplePlan, point: int) -> list[str]:
    """Return the numeric variations at a point as text, `cycle of the step = 0.2`."""
    index = np.unravel_index(point, design.shape)
    return [
        value_text(column.name, column.values[int(k)], column.unit)
        for axis, k in zip(design.axes, index, strict=True)
        for column in axis.columns
        if column.numeric
    ]
