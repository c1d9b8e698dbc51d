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

ROW, C_B = 0, 1  # columns of Motion.bearings


class Motion(NamedTuple):
    """Coefficients of q'' = steady + cosine cos(theta) + sine sin(theta) - K q - C q' during one step.

    coefficients
        Shape (2 n + 3, n): the columns of K = M^-1 (K - force gradients + passive bearings), the columns of
        C = M^-1 (C + Omega G), then steady, cosine and sine; everything in SI units.
    bearings
        Row of x and passive damping (N s/m) of each bearing, shape (n_bearings, 2).
    theta, Omega
        Rotor angle at the beginning of the step (rad) and spin speed (rad/s).
    """

    coefficients: Array
    bearings: Array
    theta: float
    Omega: float


@kernel
def prepare(
    s: Structure, parameters: Array, inputs: Array, theta: float, coefficients: Array, bearings: Array
) -> Motion:
    """Collect the coefficients of a step into the given arrays (3.1 to 3.6, 3.13).

    Bearing force on the rotor, for each axis: F + k_xx (x - x_ref) - k_b x - c_b x'.
    Unbalance: f_x + i f_y = u exp(i (theta + phi)) Omega^2.
    """
    n = s.M.shape[0]
    Omega = inputs[OMEGA]
    steady = coefficients[2 * n]
    cosine = coefficients[2 * n + 1]
    sine = coefficients[2 * n + 2]
    for i in range(n):
        steady[i] = s.MinvB_base[i, 0] * inputs[BASE] + s.MinvB_base[i, 1] * inputs[BASE + 1]
        cosine[i] = 0.0
        sine[i] = 0.0
        for j in range(n):
            coefficients[j, i] = s.MinvK[i, j]
            coefficients[n + j, i] = Omega * s.MinvG[i, j]
    for d in range(N_DISCS):
        at = DISC + d * DISC_INPUTS
        radial = inputs[at + UNBALANCE] * Omega * Omega
        a = radial * math.cos(inputs[at + PHASE])
        b = radial * math.sin(inputs[at + PHASE])
        for i in range(n):
            f_x = s.MinvB_disc[i, 2 * d]
            f_y = s.MinvB_disc[i, 2 * d + 1]
            steady[i] += f_x * inputs[at + DISC_FORCE_X] + f_y * inputs[at + DISC_FORCE_Y]
            cosine[i] += f_x * a + f_y * b
            sine[i] += f_y * a - f_x * b
    for k in range(N_BEARINGS):
        k_b = parameters[BEARING + k * BEARING_PARAMETERS + STIFFNESS]
        bearings[k, ROW] = s.rows[k]
        bearings[k, C_B] = parameters[BEARING + k * BEARING_PARAMETERS + DAMPING]
        for axis in range(2):
            at = AXIS + (2 * k + axis) * AXIS_INPUTS
            row = int(s.rows[k]) + axis
            force = inputs[at + FORCE] - inputs[at + GRADIENT] * inputs[at + REFERENCE]
            for i in range(n):
                effect = s.Minv[i, row]
                steady[i] += effect * force
                coefficients[row, i] += effect * (k_b - inputs[at + GRADIENT])
                coefficients[n + row, i] += effect * bearings[k, C_B]
    return Motion(coefficients, bearings, theta, Omega)


@kernel
def free_acceleration(m: Motion, tau: float, q: Array, v: Array, a: Array) -> None:
    """Write the acceleration without contact, at time `tau` (s) after the beginning of the step, into `a`."""
    n = q.shape[0]
    c = m.coefficients
    cosine = math.cos(m.theta + m.Omega * tau)
    sine = math.sin(m.theta + m.Omega * tau)
    for i in range(n):
        a[i] = c[2 * n, i] + cosine * c[2 * n + 1, i] + sine * c[2 * n + 2, i]
    for j in range(n):
        for i in range(n):
            a[i] -= c[j, i] * q[j] + c[n + j, i] * v[j]


@kernel
def damping_power(m: Motion, v: Array) -> float:
    """Heat from the passive bearings, the sum of c_b |v|^2 (W)."""
    power = 0.0
    for k in range(N_BEARINGS):
        row = int(m.bearings[k, ROW])
        power += m.bearings[k, C_B] * (v[row] * v[row] + v[row + 1] * v[row + 1])
    return power


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
