"""Rocking: to-and-fro motion of a rotor that stays at the bottom of its retainers.

With z the displacement from the centre of a retainer and z_r its mean over the last quarter of the time, the swing is

    alpha = |arg(z conj(z_r))|                                                                    (1)

To travel around the retainer, the rotor must pass its far side, where alpha = pi. It rocks steadily if alpha stays
below pi/2 in the last quarter, and, by extrapolation, also in a run twice as long. The extrapolation continues the
growth of alpha from a_1 to a_2. Here a_1 and a_2 are the largest values of alpha in the two quarters before the last
and in the last quarter, respectively. The middles of these intervals are 3/8 of the time apart:

    a_2 max(1, a_2/a_1)^(8/3) < pi/2                                                              (2)

A quarter must contain `SWINGS` periods of the pendulum whose length is the clearance c:

    T = 2 pi sqrt(c/g)                                                                            (3)

Friction on a spinning rotor displaces z_r from the lowest point, and drives the rocking.
"""

from __future__ import annotations

import math

import numpy as np

from array_types import Array, Complex

SWINGS = 5.0  # periods of (3) in a quarter
DOUBLED = 8.0 / 3.0  # exponent of (2)
STEEPEST = 0.5 * math.pi  # rad


def pendulum_period(clearance: float, gravity: float) -> float:
    """Return the period (s) of small swings in a retainer by (3), given its clearance (m) and gravity (m/s^2)."""
    return 2.0 * math.pi * math.sqrt(clearance / abs(gravity))


def steady_swing(times: Array, z: Complex, clearance: float, gravity: float) -> float | None:
    """Return the largest swing (rad) by (1) in the last quarter of the time; None if the motion is not steady rocking.

    Parameters
    ----------
    times
        Times since the release (s), ascending from 0, shape (n,).
    z
        Displacement from the centre of the retainer (m), shape (n,).
    clearance, gravity
        Clearance of the retainer (m), and gravity across the shaft (m/s^2).
    """
    end = float(times[-1])
    if not gravity or 0.25 * end < SWINGS * pendulum_period(clearance, gravity):
        return None
    last, before = times >= 0.75 * end, (times >= 0.25 * end) & (times < 0.75 * end)
    swing = np.abs(np.angle(z * np.conj(z[last].mean())))
    largest = float(swing[last].max())
    expected = largest * max(1.0, largest / float(swing[before].max())) ** DOUBLED
    return largest if expected < STEEPEST else None
