"""Recursive open-loop adaptive control: the integral law for the synchronous force (thesis 5.22, 5.23).

    U(t) = alpha integral( H(Omega) Q(t) ) dt
    u(t) = Re[U exp(j n theta)] = Re[U] cos(n theta) - Im[U] sin(n theta)

With Q = Q_0 + R U and H = -(R^H W R)^-1 R^H W this is U' = -alpha (U - U_opt): the forces approach the
weighted least-squares optimum with time constant 1/alpha, as long as the revolution that Q looks back on is
short against it.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.names import N_AXES, N_HARMONICS, N_SENSORS

N_U = 2 * N_AXES  # re, im of the forces of one harmonic
ROUNDING = 1e-12


@kernel
def step_of(h: Array, gain: float, q: Array, change: Array) -> None:
    """Step of the integral law, gain H Q (5.22).

    Parameters
    ----------
    h
        Matrix H, re and im row by row, shape (2 N_AXES N_SENSORS,) (N/m).
    gain
        alpha times the sample time; 1 for a whole update at once.
    q
        Synchronous displacements as re, im, shape (2 N_SENSORS,) (m).
    change
        Receives the step of the forces U as re, im, shape (N_U,) (N).
    """
    for axis in range(N_AXES):
        re = im = 0.0
        for s in range(N_SENSORS):
            k = 2 * (axis * N_SENSORS + s)
            re += h[k] * q[2 * s] - h[k + 1] * q[2 * s + 1]
            im += h[k] * q[2 * s + 1] + h[k + 1] * q[2 * s]
        change[2 * axis] = gain * re
        change[2 * axis + 1] = gain * im


@kernel
def forces_at(forces: Array, orders: Array, theta: float, u: Array) -> None:
    """u = Re[U] cos(n theta) - Im[U] sin(n theta) of each axis, all harmonics added (5.23).

    Parameters
    ----------
    forces
        Forces of all harmonics, shape (N_HARMONICS N_U,) (N).
    orders
        Orders n of the harmonics, shape (N_HARMONICS,); the first 0 ends them.
    theta
        Rotor angle (rad).
    u
        Receives the force of each axis, shape (N_AXES,) (N).
    """
    u[:] = 0.0
    for k in range(N_HARMONICS):
        if orders[k] == 0.0:
            break
        cos, sin = math.cos(orders[k] * theta), math.sin(orders[k] * theta)
        for axis in range(N_AXES):
            at = k * N_U + 2 * axis
            u[axis] += forces[at] * cos - forces[at + 1] * sin


@kernel
def limit(forces: Array, largest: float) -> bool:
    """Scale the forces of an axis back where their amplitudes add up to more than `largest` (N); whether any is there.

    The forces are the integrals themselves, so a limited force does not wind up.

    Parameters
    ----------
    forces
        Forces of all harmonics, shape (N_HARMONICS N_U,) (N); changed.
    """
    limited = False
    for axis in range(N_AXES):
        total = 0.0
        for k in range(N_HARMONICS):
            at = k * N_U + 2 * axis
            total += math.hypot(forces[at], forces[at + 1])
        limited = limited or total > (1.0 - ROUNDING) * largest
        if total > largest:
            for k in range(N_HARMONICS):
                at = k * N_U + 2 * axis
                forces[at] *= largest / total
                forces[at + 1] *= largest / total
    return limited
