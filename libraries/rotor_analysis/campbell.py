"""Campbell diagram: damped frequencies and damping ratios as functions of the spin speed, and the critical speeds."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.modes import Mode, Whirl, modes
from rotor_analysis.tracking import ModesOverSpeed, continue_modes, modes_begun_later, pair_modes, track_modes


@dataclass(frozen=True)
class CriticalSpeed:
    """A spin speed that equals the damped frequency of a mode.

    Omega
        Spin speed (rad/s).
    number
        Number of the mode in the diagram, from 1.
    damping_ratio, whirl
        Damping ratio and direction of whirl of the mode at this speed. Unbalance excites forward whirl, but not the
        backward modes of an isotropic rotor.
    """

    Omega: float
    number: int
    damping_ratio: float
    whirl: Whirl


@dataclass(frozen=True)
class Campbell:
    """Modes over speed.

    speeds
        Spin speeds (rad/s), shape (n,).
    tracks
        For each mode, its state at each speed; None before the mode begins to oscillate and after it stops.
    critical_speeds
        Intersections with the synchronous line, ascending.
    """

    speeds: Array
    tracks: tuple[tuple[Mode | None, ...], ...]
    critical_speeds: tuple[CriticalSpeed, ...]

    @property
    def frequencies(self) -> Array:
        """Damped natural frequencies (rad/s), shape (modes, n); NaN where a mode does not oscillate."""
        return np.array([[np.nan if mode is None else mode.frequency for mode in track] for track in self.tracks])

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios, shape (modes, n); NaN where a mode does not oscillate."""
        return np.array([[np.nan if mode is None else mode.damping_ratio for mode in track] for track in self.tracks])


def campbell(model: Matrices, speeds: Array, count: int = 8) -> Campbell:
    """Track `count` modes over `speeds` and find their intersections with the synchronous line.

    |Im lambda_k(Omega)| = Omega,  (lambda^2 M + lambda (C + Omega G) + K + D) phi = 0

    A crossing between two speeds is refined by Brent's method, which solves the eigenproblem at each trial speed and
    identifies the mode by its shape. Two crossings of a mode between adjacent speeds are not found.

    Parameters
    ----------
    model
        A model with its bearings.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    count
        Number of modes to track: the lowest ones at the first speed. Slow modes that begin to oscillate at a higher
        speed are added after them (`modes_begun_later`).

    Raises
    ------
    ValueError
        If the speeds are not finite and ascending, or `count` is below 1.
    """
    speeds = np.atleast_1d(np.asarray(speeds, dtype=np.float64))
    over_speed = ModesOverSpeed(model)
    tracks = track_modes(over_speed, speeds, count)
    tracks += modes_begun_later(over_speed, speeds, tracks)
    crossings: list[CriticalSpeed] = []
    for number, track in enumerate(tracks, start=1):
        for (low, mode), (high, after) in pairwise(zip(speeds.tolist(), track, strict=True)):
            if mode and after and (mode.frequency > low) != (after.frequency > high):
                crossings.append(_crossing(model, over_speed, number, mode, low, high))
    return Campbell(
        speeds, tuple(tuple(track) for track in tracks), tuple(sorted(crossings, key=lambda crossing: crossing.Omega))
    )


def _crossing(
    model: Matrices, over_speed: ModesOverSpeed, number: int, mode: Mode, low: float, high: float
) -> CriticalSpeed:
    def mode_at(Omega: float) -> Mode | None:
        return continue_modes(over_speed, [mode], low, Omega)[0] if Omega > low else mode

    def frequency_excess(Omega: float) -> float:
        """Return damped frequency minus spin speed; the frequency of a mode that does not oscillate is 0."""
        continued = mode_at(Omega)
        return (continued.frequency if continued else 0.0) - Omega

    Omega = float(brentq(frequency_excess, low, high, xtol=1e-9, rtol=1e-12))
    critical = mode_at(Omega) or mode
    if model.hysteresis is not None:  # its damping changes sign at this frequency
        synchronous = modes(model, Omega, omega=Omega)
        index = pair_modes(model.M, [critical.shape], [candidate.shape for candidate in synchronous])[0][0]
        critical = critical if index is None else synchronous[index]
    return CriticalSpeed(Omega, number, critical.damping_ratio, critical.whirl)
