"""Recursive open-loop adaptive control: the integral law for the synchronous force (thesis 5.22, 5.23).

    U(t) = alpha integral( H(Omega) Q(t) ) dt
    u(t) = Re[U exp(j n theta)] = Re[U] cos(n theta) - Im[U] sin(n theta)

With Q = Q_0 + R U and H = -(R^H W R)^-1 R^H W this is U' = -alpha (U - U_opt): the forces approach the
weighted least-squares optimum with time constant 1/alpha, as long as the revolution over which Q is averaged is
short against it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import Complex, phasor
from rolac_controller.rig_layout import N_AXES, N_HARMONICS, N_SENSORS

ROUNDING = 1e-12


@kernel
def integral_step(H: Complex, gain: float, Q: Complex, delta_U: Complex) -> None:
    """Compute the step of the integral law, gain H Q (5.22).

    Parameters
    ----------
    H
        Shape (N_AXES, N_SENSORS) (N/m).
    gain
        alpha times the sample time; 1 for a whole update at once.
    Q
        Synchronous displacements, shape (N_SENSORS,) (m).
    delta_U
        Receives the step of the forces U, shape (N_AXES,) (N).
    """
    for axis in range(N_AXES):
        total = 0j
        for s in range(N_SENSORS):
            total += H[axis, s] * Q[s]
        delta_U[axis] = gain * total


@kernel
def forces_at(U: Complex, harmonics: NDArray[np.record], theta: float, u: Array) -> None:
    """Compute u = Re[U exp(j n theta)] of each axis, all harmonics added (5.23).

    Parameters
    ----------
    U
        Forces of all harmonics, shape (N_HARMONICS, N_AXES) (N).
    harmonics
        Records HARMONIC, shape (N_HARMONICS,); the first order 0 ends them.
    theta
        Rotor angle (rad).
    u
        Receives the force of each axis, shape (N_AXES,) (N).
    """
    u[:] = 0.0
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        rotation = phasor(harmonics[k].order * theta)
        for axis in range(N_AXES):
            u[axis] += (U[k, axis] * rotation).real


@kernel
def limit_forces(U: Complex, largest: float) -> bool:
    """Scale the forces of an axis back where their amplitudes add up to more than `largest`; return if any does.

    The forces are the integrals themselves, so a limited force does not wind up.

    Parameters
    ----------
    U
        Forces of all harmonics, shape (N_HARMONICS, N_AXES) (N); changed.
    largest
        Largest sum of the amplitudes of an axis (N).
    """
    limited = False
    for axis in range(N_AXES):
        total = 0.0
        for k in range(N_HARMONICS):
            total += abs(U[k, axis])
        limited = limited or total > (1.0 - ROUNDING) * largest
        if total > largest:
            for k in range(N_HARMONICS):
                U[k, axis] *= largest / total
    return limited
