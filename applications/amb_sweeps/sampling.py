"""The points of a sweep: the product of its axes, and samples of its ranges (scipy.stats.qmc)."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from amb_cosim.cosim.system.values import Raw
from amb_sweeps.axes import MOST_POINTS, Axis, Column, Sampled, Vary, read_variations

SAMPLE = "sample"  # name of the axis of sampled points
POINT = "point"  # name of the axis of listed points
GROWING = ("random", "sobol")  # methods whose first points do not depend on their number


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

    def extremes(self) -> Iterator[int]:
        """Yield the points of a sample that have the least and the largest value of a variable."""
        columns = [np.asarray(column.values) for column in self.axes[0].columns]
        yield from sorted({0, *(int(k) for values in columns for k in (values.argmin(), values.argmax()))})

    def with_units(self, units: Mapping[str, str]) -> SamplePlan:
        """Return a copy in which numbers without a unit have the unit that `units` contains for their variable."""

        def labelled(column: Column) -> Column:
            unit = units.get(column.name, "")
            return replace(column, unit=unit) if column.numeric and not column.unit and unit != "1" else column

        axes = (replace(axis, columns=tuple(labelled(column) for column in axis.columns)) for axis in self.axes)
        return replace(self, axes=tuple(axes))

    @property
    def method(self) -> str:
        """Sampling method: grid, random, lhs, sobol or saltelli."""
        return self.sampling.partition(":")[0]

    def first(self, count: int) -> SamplePlan:
        """Return a copy with the first `count` points of its sample only."""

        def cut(axis: Axis) -> Axis:
            columns = tuple(replace(column, values=column.values[:count]) for column in axis.columns)
            return replace(axis, columns=columns) if axis.name == SAMPLE else axis

        return replace(self, axes=tuple(cut(axis) for axis in self.axes), sampling=f"{self.method}:{count}")

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
        `grid`, or `random:N` (independent points), `lhs:N` (Latin hypercube), `sobol:N` (Sobol sequence, scrambled) or
        `saltelli:N` (for the indices of `sensitivity`), which draw N points from the ranges and distributions. These
        points are combined with each value of the other axes, so all alternatives have the same samples.
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
            raise ValueError(f"{names} has no count; write START:STOP:COUNT, or sample='random:N'")
        design = SamplePlan(axes)
    else:
        method, count = _method(sample)
        if not ranges:
            raise ValueError(f"sample = {sample!r} has nothing to sample; write a range START:STOP without a count")
        shares = _draw(method, count, [group[0].name for group in ranges], seed)
        design = SamplePlan((*axes, sampled_axis(ranges, shares)), sample, seed)
    if design.size > MOST_POINTS:
        raise ValueError(f"{design.size} points are not allowed; the limit is {MOST_POINTS}")
    return design


def sampled_axis(ranges: list[tuple[Sampled, ...]], shares: np.ndarray[Any, Any]) -> Axis:
    """Return the axis whose points lie at these shares of ranges and distributions, shape (points, ranges)."""
    grouped = zip(ranges, shares.T, strict=True)
    return Axis(
        SAMPLE,
        tuple(Column(part.name, part.at(of_group), part.unit) for group, of_group in grouped for part in group),
    )


def _method(sample: str) -> tuple[str, int]:
    match = re.fullmatch(r"(random|lhs|sobol|saltelli):(\d+)", sample)
    if match is None or not 1 <= int(match[2]) <= MOST_POINTS:
        allowed = f"grid, boundary:METRIC, random:N, lhs:N, sobol:N or saltelli:N, with N from 1 to {MOST_POINTS}"
        raise ValueError(f"sample = {sample!r} is not allowed; it must be {allowed}")
    return match[1], int(match[2])


def _draw(method: str, count: int, names: list[str], seed: int) -> np.ndarray[Any, Any]:
    from scipy.stats import qmc

    dimensions = len(names)
    if method == "random":
        return np.column_stack([_independent(count, seed, name) for name in names])
    if method == "saltelli":
        return _saltelli(count, dimensions, seed)
    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count))
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return np.asarray(sequence.random_base2(max(count - 1, 0).bit_length()))[:count]  # no warning about its balance


def _independent(count: int, seed: int, name: str) -> np.ndarray[Any, Any]:
    """Return uniform numbers; the i-th depends on seed, i and name alone (Philox, keyed by the seed and the name)."""
    digest = hashlib.sha256(f"{seed} {name}".encode()).digest()
    key = np.frombuffer(digest, "<u8", 2)
    return np.asarray(np.random.Generator(np.random.Philox(key=key)).random(count))


def _saltelli(count: int, dimensions: int, seed: int) -> np.ndarray[Any, Any]:
    """Return Saltelli's sample of the unit cube, shape (count (dimensions + 2), dimensions); count is a power of 2.

    Raises
    ------
    ValueError
        If the count is not a power of 2.
    """
    from SALib.sample import sobol

    if count < 2 or count & (count - 1):
        raise ValueError(f"sample = 'saltelli:{count}' is not allowed; it must be a power of 2, such as 64")
    return np.asarray(sobol.sample(unit_problem(dimensions), count, calc_second_order=False, seed=seed))


def unit_problem(dimensions: int) -> dict[str, Any]:
    """Return SALib's description of the unit cube."""
    return {
        "num_vars": dimensions,
        "names": [str(k) for k in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }
