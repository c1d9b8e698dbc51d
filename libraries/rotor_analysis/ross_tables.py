"""Speed-dependent coefficients in a file of ROSS before version 3, which interpolates them by splines.

For four or more speeds, the spline is cubic and smooths the values; it is a parabola for three speeds, and a line for
two. A rotor file interpolates monotonically between the speeds of its table, so its table needs more speeds to match
the spline.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from array_types import Array
from rotor_analysis.ross_parts import AXES, SavedBearing

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

ACCURACY = 3e-5  # error between the sampled speeds, over the largest value of a coefficient
OVERSHOOT = 0.05  # of the largest saved value, by which a spline leaves the saved values without a note


def sampled(bearing: SavedBearing) -> SavedBearing:
    """Return a bearing with enough speeds for monotone interpolation between them to match ROSS's spline."""
    splines = _splines(bearing)
    if not splines:
        return bearing
    speeds = _dense(list(splines.values()), np.array(bearing.speed))
    curves = {name: spline(speeds).tolist() for name, spline in splines.items()}
    zeros = {name: [0.0] * len(speeds) for name in _names(bearing) if name not in curves}
    return bearing.model_copy(update={"speed": speeds.tolist(), **zeros, **curves})


def beyond_saved(bearing: SavedBearing) -> Iterator[str]:
    """Yield a note for each coefficient whose spline leaves the range of its saved values."""
    if bearing.interpolation != "spline":
        return
    for name, spline in _splines(bearing).items():
        saved, speeds = np.array(getattr(bearing, name)), _dense([spline], np.array(bearing.speed))
        values = spline(speeds)
        excess = np.maximum(values - saved.max(), saved.min() - values)
        k = int(excess.argmax())
        if excess[k] > OVERSHOOT * np.abs(saved).max():
            span = f"outside the saved range {saved.min():.4g} to {saved.max():.4g}"
            yield f"{bearing.tag}: ROSS's spline of {name} is {values[k]:.4g} at {speeds[k]:.4g} rad/s, {span}."


def _names(bearing: SavedBearing) -> list[str]:
    """Return the names of the coefficients of a bearing."""
    return [f"{letter}{axes}" for letter in "kcm" for axes in AXES if getattr(bearing, f"{letter}{axes}")]


def _splines(bearing: SavedBearing) -> dict[str, BSpline]:
    """Return ROSS's splines of the nonzero coefficients, or an empty mapping if the speeds do not ascend."""
    from scipy.interpolate import BSpline, make_interp_spline, splrep  # slow to import

    speeds = bearing.speed or []
    if len(speeds) < 2 or any(b <= a for a, b in pairwise(speeds)):
        return {}
    curves = {name: values for name in _names(bearing) if any(values := getattr(bearing, name))}
    if len(speeds) < 4:
        return {name: make_interp_spline(speeds, values, k=len(speeds) - 1) for name, values in curves.items()}
    return {name: BSpline(*splrep(speeds, values, s=len(speeds))) for name, values in curves.items()}


def _dense(splines: list[BSpline], speeds: Array) -> Array:
    """Return the speeds, with others halfway between them where monotone interpolation would not be accurate."""
    from scipy.interpolate import PchipInterpolator  # slow to import

    scales = [np.abs(spline(speeds)).max() for spline in splines]
    while True:
        halves = speeds[:-1] + 0.5 * np.diff(speeds)
        between = np.concatenate([speeds[:-1] + share * np.diff(speeds) for share in (0.25, 0.5, 0.75)])
        differences = [
            np.abs(PchipInterpolator(speeds, spline(speeds))(between) - spline(between)) / scale
            for spline, scale in zip(splines, scales, strict=True)
        ]
        error = np.max(differences, axis=0).reshape(3, -1).max(axis=0)
        if not (error > ACCURACY).any():
            return speeds
        speeds = np.sort(np.concatenate([speeds, halves[error > ACCURACY]]))
