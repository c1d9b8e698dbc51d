"""Lateral acceleration of the rotor between contacts, with everything that is constant over a step collected once."""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.interface import (
    AXIS,
    AXIS_INPUTS,
    BASE,
    BEARING,
    BEARING_PARAMETERS,
    CORE,
    CORE_INPUTS,
    DAMPING,
    DISC,
    DISC_FORCE_X,
    DISC_FORCE_Y,
    DISC_INPUTS,
    FORCE,
    GRADIENT,
    GRAVITY,
    N_BEARINGS,
    N_DISCS,
    OMEGA,
    OMEGA_DOT,
    PHASE,
    REFERENCE,
    STIFFNESS,
    UNBALANCE,
)
from rotor_contact.structure import Structure

ROW, K_B, C_B, GRADIENT_X, GRADIENT_Y = range(5)  # columns of Motion.bearings
BEARING_COLUMNS = 5
STEADY, COSINE, SINE = range(3)  # rows of Motion.forces, and the last rows of Motion.coefficients


class Motion(NamedTuple):
    """Coefficients of q'' = steady + A cosine + B sine - K q - C q' during one step.

    A + i B = exp(i theta) (Omega^2 - i Omega') is the direction and size of a unit unbalance.

    coefficients
        Shape (2 n + 3, n): the columns of K = M^-1 (K - force gradients + passive bearings), the columns of
        C = M^-1 (C + Omega G) at the beginning of the step, then steady, cosine and sine; everything in SI units.
    forces
        The forces (N) behind steady, cosine and sine, shape (3, n).
    bearings
        Row of x, passive stiffness (N/m) and damping (N s/m) and the two force gradients (N/m) of each bearing, shape
        (n_bearings, 5).
    MinvG
        M^-1 G, for speeds that change within the step, shape (n, n).
    theta, Omega, Omega_dot
        Rotor angle (rad) and spin speed (rad/s) at the beginning of the step, spin acceleration (rad/s^2).
    """

    coefficients: Array
    forces: Array
    bearings: Array
    MinvG: Array
    theta: float
    Omega: float
    Omega_dot: float


@kernel
def collect_forces(
    s: Structure, parameters: Array, inputs: Array, theta: float, coefficients: Array, forces: Array, bearings: Array
) -> Motion:
    """Collect the forces of a step into `forces` and `bearings` (3.1 to 3.6); `coefficients` are not written yet.

    Bearing force on the rotor, for each axis: F + k_xx (x - x_ref) - k_b x - c_b x'.
    Unbalance: f_x + i f_y = u exp(i (theta + phi)) (Omega^2 - i Omega').
    Gravity g acts like an acceleration g / sqrt(2) of the base along both axes.
    """
    n = s.M.shape[0]
    held_up = parameters[GRAVITY] * math.sqrt(0.5)
    for i in range(n):
        forces[STEADY, i] = s.B_base[i, 0] * (inputs[BASE] + held_up) + s.B_base[i, 1] * (inputs[BASE + 1] + held_up)
        forces[COSINE, i] = 0.0
        forces[SINE, i] = 0.0
    for d in range(N_DISCS):
        at = DISC + d * DISC_INPUTS
        a, b = _marked(inputs[at + UNBALANCE], inputs[at + PHASE])
        for i in range(n):
            f_x = s.B_disc[i, 2 * d]
            f_y = s.B_disc[i, 2 * d + 1]
            forces[STEADY, i] += f_x * inputs[at + DISC_FORCE_X] + f_y * inputs[at + DISC_FORCE_Y]
            forces[COSINE, i] += f_x * a + f_y * b
            forces[SINE, i] += f_y * a - f_x * b
    for k in range(N_BEARINGS):
        row = int(s.bearings[k])
        own = BEARING + k * BEARING_PARAMETERS
        bearings[k, ROW] = row
        bearings[k, K_B] = parameters[own + STIFFNESS]
        bearings[k, C_B] = parameters[own + DAMPING]
        core = CORE + k * CORE_INPUTS
        a, b = _marked(inputs[core + UNBALANCE], inputs[core + PHASE])
        forces[COSINE, row] += a
        forces[COSINE, row + 1] += b
        forces[SINE, row] -= b
        forces[SINE, row + 1] += a
        for axis in range(2):
            at = AXIS + (2 * k + axis) * AXIS_INPUTS
            bearings[k, GRADIENT_X + axis] = inputs[at + GRADIENT]
            forces[STEADY, row + axis] += inputs[at + FORCE] - inputs[at + GRADIENT] * inputs[at + REFERENCE]
    return Motion(coefficients, forces, bearings, s.MinvG, theta, inputs[OMEGA], inputs[OMEGA_DOT])


@kernel
def _marked(unbalance: float, phase: float) -> tuple[float, float]:
    """x and y of an unbalance (kg m) at a rotor angle of zero."""
    if unbalance == 0.0:
        return 0.0, 0.0
    return unbalance * math.cos(phase), unbalance * math.sin(phase)


@kernel
def collect_coefficients(s: Structure, m: Motion) -> None:
    """Write the coefficients of a step from its forces (3.13)."""
    n = s.M.shape[0]
    c = m.coefficients
    for i in range(n):
        for j in range(n):
            c[j, i] = s.MinvK[i, j]
            c[n + j, i] = m.Omega * s.MinvG[i, j]
    for k in range(N_BEARINGS):
        row = int(m.bearings[k, ROW])
        for axis in range(2):
            for i in range(n):
                effect = s.Minv[i, row + axis]
                c[row + axis, i] += effect * (m.bearings[k, K_B] - m.bearings[k, GRADIENT_X + axis])
                c[n + row + axis, i] += effect * m.bearings[k, C_B]
    for kind in range(3):
        for i in range(n):
            c[2 * n + kind, i] = 0.0
        for j in range(n):
            if m.forces[kind, j] != 0.0:
                for i in range(n):
                    c[2 * n + kind, i] += s.Minv[j, i] * m.forces[kind, j]


@kernel
def spin(m: Motion, tau: float) -> float:
    """Spin speed (rad/s) at `tau` (s) after the beginning of the step."""
    return m.Omega + m.Omega_dot * tau


@kernel
def unbalance_direction(m: Motion, tau: float) -> tuple[float, float]:
    """A and B of A + i B = exp(i theta) (Omega^2 - i Omega') (rad^2/s^2)."""
    Omega = spin(m, tau)
    theta = m.theta + 0.5 * (m.Omega + Omega) * tau
    cosine = math.cos(theta)
    sine = math.sin(theta)
    return Omega * Omega * cosine + m.Omega_dot * sine, Omega * Omega * sine - m.Omega_dot * cosine


@kernel
def free_acceleration(m: Motion, tau: float, along: float, across: float, q: Array, v: Array, a: Array) -> None:
    """Write the acceleration without contact into `a`, at `tau` (s) after the beginning of the step.

    `along` and `across` are the `unbalance_direction` then.
    """
    n = q.shape[0]
    c = m.coefficients
    for i in range(n):
        a[i] = c[2 * n, i] + along * c[2 * n + 1, i] + across * c[2 * n + 2, i]
    for j in range(n):
        for i in range(n):
            a[i] -= c[j, i] * q[j] + c[n + j, i] * v[j]
    if m.Omega_dot != 0.0:
        faster = m.Omega_dot * tau
        for i in range(n):
            for j in range(n):
                a[i] -= faster * m.MinvG[i, j] * v[j]


@kernel
def input_power(m: Motion, along: float, across: float, q: Array, v: Array) -> float:
    """Work of all forces given as inputs, in a second (W), with the `unbalance_direction`; passive bearings do none."""
    power = 0.0
    for i in range(q.shape[0]):
        power += v[i] * (m.forces[STEADY, i] + along * m.forces[COSINE, i] + across * m.forces[SINE, i])
    for k in range(N_BEARINGS):
        row = int(m.bearings[k, ROW])
        power += m.bearings[k, GRADIENT_X] * q[row] * v[row]
        power += m.bearings[k, GRADIENT_Y] * q[row + 1] * v[row + 1]
    return power


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
