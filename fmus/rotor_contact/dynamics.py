"""Lateral acceleration of the rotor between contacts, with everything that is constant over a step collected once."""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.constants import Structure
from rotor_contact.interface import (
    AXIS,
    AXIS_INPUTS,
    BASE,
    BEARING,
    BEARING_PARAMETERS,
    DAMPING,
    DISC,
    DISC_FORCE_X,
    DISC_FORCE_Y,
    DISC_INPUTS,
    FORCE,
    GRADIENT,
    N_BEARINGS,
    N_DISCS,
    OMEGA,
    PHASE,
    REFERENCE,
    STIFFNESS,
    UNBALANCE,
)


class Motion(NamedTuple):
    """Coefficients of q'' = steady + cosine cos(theta) + sine sin(theta) - K q - C q' during one step.

    K, C
        M^-1 (K - force gradients + passive bearings) and M^-1 (C + Omega G), shape (n, n).
    steady, cosine, sine
        Accelerations, shape (n,).
    theta, Omega
        Rotor angle at the beginning of the step (rad) and spin speed (rad/s).
    """

    K: Array
    C: Array
    steady: Array
    cosine: Array
    sine: Array
    theta: float
    Omega: float


@kernel
def prepare(
    s: Structure,
    parameters: Array,
    inputs: Array,
    theta: float,
    K: Array,
    C: Array,
    steady: Array,
    cosine: Array,
    sine: Array,
) -> Motion:
    """Collect the coefficients of a step into the given arrays (3.1 to 3.6, 3.13).

    Bearing force on the rotor, for each axis: F + k_xx (x - x_ref) - k_b x - c_b x'.
    Unbalance: f_x + i f_y = u exp(i (theta + phi)) Omega^2.
    """
    n = s.M.shape[0]
    Omega = inputs[OMEGA]
    for i in range(n):
        steady[i] = s.MinvB_base[i, 0] * inputs[BASE] + s.MinvB_base[i, 1] * inputs[BASE + 1]
        cosine[i] = 0.0
        sine[i] = 0.0
        for j in range(n):
            K[j, i] = s.MinvK[i, j]
            C[j, i] = Omega * s.MinvG[i, j]
        for d in range(N_DISCS):
            at = DISC + d * DISC_INPUTS
            f_x = s.MinvB_disc[i, 2 * d]
            f_y = s.MinvB_disc[i, 2 * d + 1]
            steady[i] += f_x * inputs[at + DISC_FORCE_X] + f_y * inputs[at + DISC_FORCE_Y]
            radial = inputs[at + UNBALANCE] * Omega * Omega
            a = radial * math.cos(inputs[at + PHASE])
            b = radial * math.sin(inputs[at + PHASE])
            cosine[i] += f_x * a + f_y * b
            sine[i] += f_y * a - f_x * b
        for k in range(N_BEARINGS):
            k_b = parameters[BEARING + k * BEARING_PARAMETERS + STIFFNESS]
            c_b = parameters[BEARING + k * BEARING_PARAMETERS + DAMPING]
            for axis in range(2):
                at = AXIS + (2 * k + axis) * AXIS_INPUTS
                row = int(s.rows[k]) + axis
                effect = s.Minv[i, row]
                steady[i] += effect * (inputs[at + FORCE] - inputs[at + GRADIENT] * inputs[at + REFERENCE])
                K[row, i] += effect * (k_b - inputs[at + GRADIENT])
                C[row, i] += effect * c_b
    return Motion(K, C, steady, cosine, sine, theta, Omega)


@kernel
def free_acceleration(m: Motion, tau: float, q: Array, v: Array, a: Array) -> None:
    """Write the acceleration without contact, at time `tau` (s) after the beginning of the step, into `a`."""
    angle = m.theta + m.Omega * tau
    cosine = math.cos(angle)
    sine = math.sin(angle)
    n = q.shape[0]
    for i in range(n):
        a[i] = m.steady[i] + cosine * m.cosine[i] + sine * m.sine[i]
    for j in range(n):
        for i in range(n):
            a[i] -= m.K[j, i] * q[j] + m.C[j, i] * v[j]


@kernel
def quadratic_form(A: Array, x: Array) -> float:
    """x^T A x."""
    total = 0.0
    for i in range(x.shape[0]):
        row = 0.0
        for j in range(x.shape[0]):
            row += A[i, j] * x[j]
        total += x[i] * row
    return total
