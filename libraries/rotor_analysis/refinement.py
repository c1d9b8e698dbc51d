"""Sampling of curves: samples are added about each maximum until the largest sample is as high as the maximum.

Near a resonance a response is h = a/(x - x_0 - j sigma), so that the inverse of its square is a parabola:

    |h|^-2 = ((x - x_0)^2 + sigma^2)/|a|^2                                                        (1)

Three samples determine x_0 and sigma, even of a peak that is much narrower than their spacing. Samples are added if the
parabola predicts a higher maximum than the samples show, or if the samples are too far apart. They are added at x_0 +
sigma tan(psi), which divides the circle of h evenly, and halfway between a maximum and a neighbour that is less than
half as high.

On any other curve, three samples do not show a peak that is narrower than their spacing. The outer two may lie evenly
on its flanks while the middle one is not at its top. A maximum is therefore accepted only if the second differences at
its neighbours are about as large as at the maximum. Otherwise the intervals on both sides of the maximum are halved. A
maximum at an end is accepted if a sample close to it is lower.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from array_types import Array, Indices

ACCURACY = 1e-3  # of a maximum, relative to it or to its height above its neighbours
ROUNDS = 16  # in which samples are added; the distance shrinks by a factor of ten or more in each
FAN = np.tan(np.linspace(-1.45, 1.45, 17))  # about a peak, in half widths
CIRCLE = np.tan(np.linspace(-1.45, 1.45, 33))  # about a computed resonance, whose circle is drawn
FEW = np.array([-1.0, 0.0, 1.0])  # about the top of a smooth curve
NEAR, WIDER = 0.2, 5.0  # distance and width of a peak, in half widths of a sharper one whose samples serve both
FINE = 0.25  # half widths, the largest distance of samples at a maximum
STEEP = 0.5  # of a maximum; lower neighbours are too far away to show its shape
EVEN = 0.2, 2.5  # least and largest curvature at a neighbour of a maximum, over that at it, about a single smooth top
FLAT = 1e-5  # of a maximum; it is due to rounding if it exceeds its neighbours by less
END, NEXT = 1e-4, 0.02  # of the range and of the second distance: the first distance that shows the slope at an end
SAME = 1e-12  # relative distance of equal samples

Samples = NDArray[Any]


def refined(
    evaluate: Callable[[Array], Samples],
    x: Array,
    heights: Callable[[Samples], Array],
    accuracy: float = ACCURACY,
    *,
    resonant: bool = True,
) -> tuple[Array, Samples]:
    """Return samples of curves between the first and the last sample, added until they include each maximum.

    Parameters
    ----------
    evaluate
        Function that returns the values at any x, shape (n, ...).
    x
        Initial samples, ascending, shape (n,).
    heights
        Function that returns the curves whose maxima are refined, computed from the values, shape (n, ...). To refine
        minima, it can return a curve with the opposite sign.
    accuracy
        Relative accuracy of each maximum.
    resonant
        Whether maxima above 0 are resonances (1); if not, the curves are smooth and are interpolated directly by
        parabolas.

    Returns
    -------
    x, values
        Samples in ascending order, including the initial ones, shape (m,), and the values at them, shape (m, ...).
    """
    values = evaluate(x)
    for _ in range(ROUNDS):
        more = _additional_samples(x, np.asarray(heights(values)).reshape(len(x), -1), accuracy, resonant)
        if not len(more):
            break
        order = np.argsort(np.concatenate([x, more]), kind="stable")
        x, values = np.concatenate([x, more])[order], np.concatenate([values, evaluate(more)])[order]
    return x, values


def with_samples(x: Array, more: Iterable[float]) -> Array:
    """Return the sorted values of x and of `more`, such as entries of a table, that lie within the range of x."""
    return np.sort(np.concatenate([x, _between(np.array(list(more), dtype=np.float64), x)]))


def about_resonances(x: Array, resonances: Sequence[tuple[float, float]]) -> Array:
    """Return x with additional samples, all within its range, near resonances (position x_0, half-width sigma)."""
    limits = [(at, width, -np.inf, np.inf) for at, width in resonances]
    return np.sort(np.concatenate([x, _between(_fans(limits, CIRCLE), x)]))


def _additional_samples(x: Array, h: Array, accuracy: float, may_resonate: bool) -> Array:
    """Return the samples to add about maxima, in any column of h, that are not yet resolved."""
    if len(x) < 3:
        return np.empty(0)
    ends = [*_next_to_first(x, h), *(-at for at in _next_to_first(-x[::-1], h[::-1]))]
    k, curve = np.nonzero((h[1:-1] >= h[:-2]) & (h[1:-1] > h[2:]))
    if not len(k):
        return _between(np.array(ends), x)
    three = np.stack([h[k, curve], h[k + 1, curve], h[k + 2, curve]])
    before, after = x[k] - x[k + 1], x[k + 2] - x[k + 1]
    least = three.min(axis=0)
    resonant = (least > 0.0) & may_resonate
    g = np.where(resonant, (three[1] / np.where(resonant, three, 1.0)) ** 2, -three)
    at, lowest, curvature = vertex(np.stack([x[k], x[k + 1], x[k + 2]]), g)
    bounded = np.maximum(lowest, 1e-30)
    expected = np.where(resonant, three[1] / np.sqrt(bounded), -lowest)
    missed = expected - three[1] > accuracy * np.maximum(np.abs(three[1]), three[1] - least)
    nearest, farthest = np.minimum(-before, after), np.maximum(-before, after)
    width = np.where(resonant, np.sqrt(bounded / curvature), np.inf)
    coarse = resonant & (farthest > FINE * width)
    width = np.where(resonant, np.clip(width, 1e-3 * nearest, 0.5 * nearest), 0.1 * nearest)
    peaks = [(at[n], width[n], x[k[n]], x[k[n] + 2]) for n in np.flatnonzero((missed | coarse) & resonant)]
    tops = [(at[n], width[n], x[k[n]], x[k[n] + 2]) for n in np.flatnonzero(missed & ~resonant)]
    steep = [k[n] + side for side in (0, 1) for n in np.flatnonzero(resonant & (three[2 * side] < STEEP * three[1]))]
    narrow = [k[n] + side for side in (0, 1) for n in np.flatnonzero(_may_be_narrow(x, h, k, curve))]
    halves = [0.5 * (x[n] + x[n + 1]) for n in dict.fromkeys([*steep, *narrow])]
    return _between(np.concatenate([ends, _fans(peaks), _fans(tops, FEW), halves]), x)


def _may_be_narrow(x: Array, h: Array, k: Indices, curve: Indices) -> Array:
    """Return which maxima, at samples k + 1 of their curves, may be narrower than the spacing of the samples."""
    slopes = np.pad(np.diff(h, axis=0) / np.diff(x)[:, None], ((1, 1), (0, 0)))  # none beyond the ends
    distances = np.pad(np.diff(x), 1, mode="edge")
    widths = np.stack([distances[k + n] + distances[k + n + 1] for n in range(3)])
    bends = np.diff(np.stack([slopes[k + n, curve] for n in range(4)]), axis=0) / widths  # below 0 about a smooth top
    uneven = ((bends > EVEN[0] * bends[1]) | (bends < EVEN[1] * bends[1])).any(axis=0)
    rises = h[k + 1, curve] - np.stack([h[k, curve], h[k + 2, curve]])
    real = rises > FLAT * np.abs(h[k + 1, curve])
    at_end = ((k == 0) & ~real[0]) | ((k == len(x) - 3) & ~real[1])  # the end itself, within rounding
    return np.asarray(uneven & real.any(axis=0) & ~at_end)


def _next_to_first(x: Array, h: Array) -> list[float]:
    """Return a sample close to the first one if h is largest there but the slope there is not yet resolved."""
    first = x[1] - x[0]
    is_wide = first > END * (x[-1] - x[0]) and first > NEXT * (x[2] - x[1])
    return [float(x[0] + 0.5 * NEXT * first)] if is_wide and (h[0] > h[1]).any() else []


def _fans(peaks: Sequence[tuple[float, float, float, float]], offsets: Array = FAN) -> Array:
    """Return samples about peaks, each given by its position, half-width, and smallest and largest allowed sample.

    Of several peaks at about the same position, only the sharpest gets samples.
    """
    result: list[Array] = [np.empty(0)]
    placed: list[tuple[float, float]] = []
    for at, width, low, high in sorted(peaks, key=lambda peak: peak[1]):
        if all(abs(at - other) > NEAR * size or width > WIDER * size for other, size in placed):
            placed.append((at, width))
            fan = at + width * offsets
            result.append(fan[(fan > low) & (fan < high)])
    return np.concatenate(result)


def vertex(x: Array, g: Array) -> tuple[Array, Array, Array]:
    """Return position and value of the minimum of a parabola through three samples, and its second divided difference.

    Parameters
    ----------
    x, g
        Ascending positions, and the values there, the second of which is the smallest, shape (3, ...) each.
    """
    before, after = x[0] - x[1], x[2] - x[1]
    rise, fall = (g[0] - g[1]) / before, (g[2] - g[1]) / after
    curvature = (fall - rise) / (after - before)
    slope = rise - curvature * before
    return x[1] - slope / (2.0 * curvature), g[1] - slope**2 / (4.0 * curvature), curvature


def _between(more: Array, x: Array) -> Array:
    """Return the distinct values of `more` that lie between the ends of x but are not in x, in ascending order."""
    distinct = np.unique(more[(more > x[0]) & (more < x[-1])])
    distinct = distinct[np.diff(distinct, prepend=-np.inf) > SAME * np.abs(distinct)]
    after = np.clip(np.searchsorted(x, distinct), 1, len(x) - 1)
    is_new = np.minimum(distinct - x[after - 1], x[after] - distinct) > SAME * np.abs(distinct)
    return np.asarray(distinct[is_new])
