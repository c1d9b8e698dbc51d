"""The points of a sweep: the product of its axes, and samples of its ranges (scipy.stats.qmc)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from amb_cosim.cosim.system.values import Raw
from amb_sweeps.axes import MOST_POINTS, Axis, Column, Range, Vary, read_variations

SAMPLE = "sample"  # name of the axis of sampled points
POINT = "point"  # name of the axis of listed points


@dataclass(frozen=True)
class SamplePlan:
    """The axes of a sweep, whose product is the set of its points, and the sampling method."""

    axes: tuple[Axis, ...]
    sampling: str = "grid"
    seed: int | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def settings(self, point: int) -> dict[str, Raw]:
        """Return the settings of a point; later axes override earlier ones. The last axis varies fastest."""
        merged: dict[str, Raw] = {}
        for axis, k in zip(self.axes, np.unravel_index(point, self.shape), strict=True):
            merged |= axis.settings(int(k))
        return merged

    def corners(self) -> Iterator[int]:
        """Yield points that together contain each value of each axis at least once."""
        for at, axis in enumerate(self.axes):
            for k in range(len(axis)):
                index = [0] * len(self.axes)
                index[at] = k
                yield int(np.ravel_multi_index(index, self.shape))

    def with_units(self, units: Mapping[str, str]) -> SamplePlan:
        """Return a copy in which numbers without a unit have the unit that `units` contains for their variable."""

        def labelled(column: Column) -> Column:
            unit = units.get(column.name, "")
            return replace(column, unit=unit) if column.numeric and not column.unit and unit != "1" else column

        axes = (replace(axis, columns=tuple(labelled(column) for column in axis.columns)) for axis in self.axes)
        return replace(self, axes=tuple(axes))

    def as_dict(self) -> dict[str, Any]:
        """Return axes, sampling and seed, ready for JSON."""
        return asdict(self)


def sample_plan(vary: Vary, sample: str = "grid", seed: int = 0) -> SamplePlan:
    """Return the points of a sweep.

    Parameters
    ----------
    vary
        Variations; see `axes.read_variations`.
    sample
        `grid`, or `lhs:N` (Latin hypercube), `sobol:N` (Sobol sequence, scrambled) or `saltelli:N` (for the indices of
        `sensitivity`), which draw N points from the ranges. These points are combined with each value of the other
        axes, so all alternatives have the same samples.
    seed
        Seed of the samples.

    Raises
    ------
    ValueError
        If a grid has a range without a count, a sample has no such range, or there are too many points.
    """
    variations = read_variations(vary)
    axes = tuple(v for v in variations if isinstance(v, Axis))
    ranges = [v for v in variations if not isinstance(v, Axis)]
    names = ", ".join(part.name for group in ranges for part in group)
    if sample == "grid":
        if ranges:
            raise ValueError(f"{names} has no count; write START:STOP:COUNT, or --sample lhs:N")
        design = SamplePlan(axes)
    else:
        method, count = _method(sample)
        if not ranges:
            raise ValueError(f"--sample {sample} has nothing to sample; a range is NAME=START:STOP, without a count")
        shares = _draw(method, count, len(ranges), seed)
        design = SamplePlan((*axes, sampled_axis(ranges, shares)), sample, seed)
    if design.size > MOST_POINTS:
        raise ValueError(f"{design.size} points are not allowed; the limit is {MOST_POINTS}")
    return design


def sampled_axis(ranges: list[tuple[Range, ...]], shares: np.ndarray[Any, Any]) -> Axis:
    """Return the axis whose points lie at these fractions of the ranges, shape (points, ranges)."""
    columns = [part.at(of_range) for group, of_range in zip(ranges, shares.T, strict=True) for part in group]
    return Axis(SAMPLE, tuple(columns))


def _method(sample: str) -> tuple[str, int]:
    match = re.fullmatch(r"(lhs|sobol|saltelli):(\d+)", sample)
    if match is None or not 1 <= int(match[2]) <= MOST_POINTS:
        allowed = f"grid, boundary:METRIC, lhs:N, sobol:N or saltelli:N, with N from 1 to {MOST_POINTS}"
        raise ValueError(f"--sample {sample} is not allowed; it must be {allowed}")
    return match[1], int(match[2])


def _draw(method: str, count: int, dimensions: int, seed: int) -> np.ndarray[Any, Any]:
    from scipy.stats import qmc

    if method == "saltelli":
        return _saltelli(count, dimensions, seed)
    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count))
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return np.asarray(sequence.random_base2(max(count - 1, 0).bit_length()))[:count]  # no warning about its balance


def _saltelli(count: int, dimensions: int, seed: int) -> np.ndarray[Any, Any]:
    """Return Saltelli's sample of the unit cube, shape (count (dimensions + 2), dimensions); count is a power of 2.

    Raises
    ------
    ValueError
        If the count is not a power of 2.
    """
    from SALib.sample import sobol

    if count < 2 or count & (count - 1):
        raise ValueError(f"--sample saltelli:{count} is not allowed; it must be a power of 2, such as 64")
    return np.asarray(sobol.sample(unit_problem(dimensions), count, calc_second_order=False, seed=seed))


def unit_problem(dimensions: int) -> dict[str, Any]:
    """Return SALib's description of the unit cube."""
    return {
        "num_vars": dimensions,
        "names": [str(k) for k in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }
