"""Orbits at the bearings: largest radius, and synchronous amplitude."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.signals import Signals
from amb_cosim.results.places import places
from amb_cosim.results.series import change, cycles, signal, turns

When = Literal["before", "end"]

_FEWEST_SAMPLES = 8  # of a turn, for three coefficients


def radius(dataset: Signals, bearing: str) -> NDArray[np.float64] | None:
    """Return the radial displacement at a magnetic bearing, in m."""
    x, y = signal(dataset, f"{bearing}.x"), signal(dataset, f"{bearing}.y")
    return None if x is None or y is None else np.hypot(x, y)


def orbit_before(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each bearing in the last cycle before the step; None without a step."""
    step, cycle = float(dataset.attrs.get("step_cycle", -np.inf)), cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(step - 1.0, 0.0)) & (cycle < step))


def orbit_after(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each bearing in the last cycle of the run."""
    cycle = cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(cycle.max(initial=0.0) - 1.0, 0.0)))


def orbit_largest(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each bearing from cycle 0 on."""
    return _largest_radii(dataset, cycles(dataset) >= 0.0)


def settled_amplitudes(dataset: Signals) -> dict[str, dict[str, float | None]]:
    """Return the synchronous amplitude (mm) at each bearing `before` the change of the run and at its `end`."""

    def in_mm(bearing: str, when: When) -> float | None:
        amplitude = settled_amplitude(dataset, f"{bearing}.x", f"{bearing}.y", when)
        return None if amplitude is None else 1e3 * amplitude

    return {when: {mb: in_mm(mb, when) for mb in places(dataset).bearings} for when in get_args(When)}


def settled_amplitude(dataset: Signals, x: str, y: str, when: When) -> float | None:
    """Return the synchronous amplitude (m) of two displacements `before` the change of a run or at its `end`.

    The change is the step or, without one, ROLAC's beginning; see `series.change`. It is the amplitude of the last
    whole turn of the rotor up to there; None where there is none.
    """
    xs, ys, turned = signal(dataset, x), signal(dataset, y), turns(dataset)
    at = change(dataset) if when == "before" else np.inf
    if xs is None or ys is None or at is None or not len(turned):
        return None
    end = float(np.interp(at, cycles(dataset), turned))
    within = (turned > end - 1.0) & (turned <= end)
    if end - 1.0 < turned[0] or np.count_nonzero(within) < _FEWEST_SAMPLES:
        return None
    return synchronous_amplitude(xs[within], ys[within], 2.0 * np.pi * turned[within])


def synchronous_amplitude(x: NDArray[np.float64], y: NDArray[np.float64], theta: NDArray[np.float64]) -> float:
    """Fit the major semi-axis of the ellipse on which a point moves synchronously with the rotor.

        x + j y ~ z_0 + z_f exp(j theta) + z_b exp(-j theta),       a = abs(z_f) + abs(z_b)

    The three coefficients are fitted by least squares, so that a turn need not be a whole number of samples.

    Parameters
    ----------
    x, y
        Displacement at each sample of a turn, shape (n,), n >= 3 (m).
    theta
        Angle of the rotor there, shape (n,) (rad).
    """
    basis = np.exp(1j * np.outer(theta, [0.0, 1.0, -1.0]))
    (_, forward, backward), *_ = np.linalg.lstsq(basis, x + 1j * y, rcond=None)
    return float(abs(forward) + abs(backward))


def _largest_radii(dataset: Signals, within: NDArray[np.bool_]) -> dict[str, float | None]:
    radii = {mb: radius(dataset, mb) for mb in places(dataset).bearings}
    return {mb: None if r is None or not within.any() else float(1e3 * r[within].max()) for mb, r in radii.items()}
