"""Recursive open-loop adaptive control: the integral law for the synchronous force (thesis 5.22, 5.23).

    U(t) = alpha integral( H(Omega) Q(t) ) dt
    u(t) = Re[U exp(j theta)] = Re[U] cos(theta) - Im[U] sin(theta)

With Q = Q_0 + R U and H = -(R^H W R)^-1 R^H W this is U' = -alpha (U - U_opt): the forces approach the
weighted least-squares optimum with time constant 1/alpha, as long as the revolution that Q looks back on is
short against it.

The table of H is the `constants` of the model, laid out by `rolac_controller.table.pack`:
number of speeds n, n speeds (rad/s), then for each speed the 4 x 8 matrix H, row by row, as re, im (N/m).
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.fourier import N_SENSORS

N_AXES = 4
N_H = 2 * N_AXES * N_SENSORS


@kernel
def adapt(table: Array, speed: float, gain: float, q: Array, force: Array) -> None:
    """One step of the integral law, U += gain H(Omega) Q (5.22).

    H is linear in the speed between the table's speeds; below the first and above the last it is theirs.

    Parameters
    ----------
    table
        Speeds and matrices H; at least one speed.
    speed
        Omega (rad/s).
    gain
        alpha times the sample time.
    q
        Synchronous displacements as re, im, shape (2 N_SENSORS,) (m).
    force
        Synchronous forces U as re, im, shape (2 N_AXES,) (N); changed.
    """
    n = int(table[0])
    above = 0
    while above < n and table[1 + above] < speed:
        above += 1
    low, high = max(above - 1, 0), min(above, n - 1)
    share = 0.0
    if high > low:
        share = (speed - table[1 + low]) / (table[1 + high] - table[1 + low])
    h_low, h_high = 1 + n + low * N_H, 1 + n + high * N_H
    for axis in range(N_AXES):
        re = im = 0.0
        for s in range(N_SENSORS):
            k = 2 * (axis * N_SENSORS + s)
            h_re = (1.0 - share) * table[h_low + k] + share * table[h_high + k]
            h_im = (1.0 - share) * table[h_low + k + 1] + share * table[h_high + k + 1]
            re += h_re * q[2 * s] - h_im * q[2 * s + 1]
            im += h_re * q[2 * s + 1] + h_im * q[2 * s]
        force[2 * axis] += gain * re
        force[2 * axis + 1] += gain * im


@kernel
def force_at(force: Array, axis: int, theta: float) -> float:
    """u = Re[U] cos(theta) - Im[U] sin(theta) of one axis (N) (5.23)."""
    u: float = force[2 * axis] * math.cos(theta) - force[2 * axis + 1] * math.sin(theta)
    return u
