"""Lateral acceleration of the rotor between contacts, with everything that is constant over a step collected once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record
from rotor_contact.signals import Inputs, Parameters
from rotor_contact.structure import Structure

# A magnetic bearing during a step: row of its x, passive stiffness (N/m) and damping (N s/m), and the gradients (N/m)
# of its force in x and y.
BEARING = record(("row", np.int64), ("k_b", np.float64), ("c_b", np.float64), ("gradient", np.float64, (2,)))
Bearings = np.ndarray[tuple[int], np.dtype[np.record]]


class Excitation(NamedTuple):
    """Steady part, cosine part and sine part of forces (N) or of accelerations (m/s^2), shape (n,) each.

    Their sum is steady + A cosine + B sine, where A + i B = exp(i theta) (Omega^2 - i Omega') is the direction and size
    of a unit unbalance.
    """

    steady: Array
    cosine: Array
    sine: Array


class Coefficients(NamedTuple):
    """The columns of K = M^-1 (K - force gradients + passive bearings) and of C = M^-1 (C + Omega G).

    Shape (n, n) each; row j is column j, so that a product runs along the memory. Omega is that at the beginning of the
    step.
    """

    K_columns: Array
    C_columns: Array


class Motion(NamedTuple):
    """Coefficients of q'' = steady + A cosine + B sine - K q - C q' during one step (see `Excitation`).

    rows
        Shape (2 n + 6, n); `coefficients`, `accelerations` and `forces` say what they are. All kernels of a step hand
        this tuple on, which takes the longer the more arrays there are.
    bearings
        Records of type `BEARING`.
    MinvG
        M^-1 G, for speeds that change within the step, shape (n, n).
    theta, Omega, Omega_dot
        Rotor angle (rad) and spin speed (rad/s) at the beginning of the step, spin acceleration (rad/s^2).
    """

    rows: Array
    bearings: Bearings
    MinvG: Array
    theta: float
    Omega: float
    Omega_dot: float


@views
def coefficients(motion: Motion) -> Coefficients:
    """Return K and C of a motion."""
    n = motion.rows.shape[1]
    return Coefficients(motion.rows[:n], motion.rows[n : 2 * n])


@views
def accelerations(motion: Motion) -> Excitation:
    """Return the accelerations by all forces given."""
    n = motion.rows.shape[1]
    return Excitation(motion.rows[2 * n], motion.rows[2 * n + 1], motion.rows[2 * n + 2])


@views
def forces(motion: Motion) -> Excitation:
    """Return the forces behind these accelerations."""
    n = motion.rows.shape[1]
    return Excitation(motion.rows[2 * n + 3], motion.rows[2 * n + 4], motion.rows[2 * n + 5])


@kernel
def collect_forces(
    structure: Structure, parameters: Parameters, inputs: Inputs, theta: float, rows: Array, bearings: Bearings
) -> Motion:
    """Collect the forces of a step (3.1 to 3.6) in `rows` and `bearings`, the memory of the motion that is returned.

    The coefficients K, C and the accelerations are not written yet.

    Bearing force on the rotor, for each axis: F + k_xx (x - x_ref) - k_b x - c_b x'.
    Unbalance: f_x + i f_y = u exp(i (theta + phi)) (Omega^2 - i Omega').
    Gravity g acts like an acceleration g / sqrt(2) of the base along both axes.
    """
    n = structure.M.shape[0]
    u = inputs.own[0]
    motion = Motion(rows, bearings, structure.MinvG, theta, u.Omega, u.Omega_dot)
    steady, cosine, sine = forces(motion)
    gravity_xy = parameters.own[0].gravity * math.sqrt(0.5)
    a_x, a_y = u.base_acceleration.x + gravity_xy, u.base_acceleration.y + gravity_xy
    for i in range(n):
        steady[i] = structure.B_base[i, 0] * a_x + structure.B_base[i, 1] * a_y
        cosine[i] = 0.0
        sine[i] = 0.0
    for d in range(inputs.discs.shape[0]):
        disc = inputs.discs[d]
        u_x, u_y = unbalance_xy(disc.u, disc.phi)
        for i in range(n):
            f_x = structure.B_disc[i, 2 * d]
            f_y = structure.B_disc[i, 2 * d + 1]
            steady[i] += f_x * disc.f_x + f_y * disc.f_y
            cosine[i] += f_x * u_x + f_y * u_y
            sine[i] += f_y * u_x - f_x * u_y
    for k in range(bearings.shape[0]):
        bearing = bearings[k]
        row = int(structure.bearings[k])
        bearing.row = row
        bearing.k_b = parameters.bearings[k].k_b
        bearing.c_b = parameters.bearings[k].c_b
        u_x, u_y = unbalance_xy(inputs.cores[k].u, inputs.cores[k].phi)
        cosine[row] += u_x
        cosine[row + 1] += u_y
        sine[row] -= u_y
        sine[row + 1] += u_x
        for i in range(2):
            axis = inputs.axes[2 * k + i]
            bearing.gradient[i] = axis.gradient
            steady[row + i] += axis.force - axis.gradient * axis.reference
    return motion


@kernel
def unbalance_xy(unbalance: float, phase: float) -> tuple[float, float]:
    """Return x and y of an unbalance (kg m) at a rotor angle of zero."""
    if unbalance == 0.0:
        return 0.0, 0.0
    return unbalance * math.cos(phase), unbalance * math.sin(phase)


@kernel
def collect_coefficients(structure: Structure, motion: Motion) -> None:
    """Write the coefficients and accelerations of a step from its forces (3.13)."""
    n = structure.M.shape[0]
    K, C = coefficients(motion)
    for i in range(n):
        for j in range(n):
            K[j, i] = structure.MinvK[i, j]
            C[j, i] = motion.Omega * structure.MinvG[i, j]
    for bearing in motion.bearings:
        for axis in range(2):
            row = bearing.row + axis
            for i in range(n):
                effect = structure.Minv[i, row]
                K[row, i] += effect * (bearing.k_b - bearing.gradient[axis])
                C[row, i] += effect * bearing.c_b
    given, caused = forces(motion), accelerations(motion)
    _divide_by_mass(structure.Minv, given.steady, caused.steady)
    _divide_by_mass(structure.Minv, given.cosine, caused.cosine)
    _divide_by_mass(structure.Minv, given.sine, caused.sine)


@kernel
def _divide_by_mass(Minv: Array, force: Array, acceleration: Array) -> None:
    """Write M^-1 force into `acceleration`."""
    n = force.shape[0]
    for i in range(n):
        acceleration[i] = 0.0
    for j in range(n):
        if force[j] != 0.0:
            for i in range(n):
                acceleration[i] += Minv[j, i] * force[j]


@kernel
def spin_speed(motion: Motion, tau: float) -> float:
    """Return the spin speed (rad/s) at `tau` (s) after the beginning of the step."""
    return motion.Omega + motion.Omega_dot * tau


@kernel
def unbalance_direction(motion: Motion, tau: float) -> complex:
    """Return A + i B = exp(i theta) (Omega^2 - i Omega') (rad^2/s^2) at `tau` (s) after the beginning of the step."""
    Omega = spin_speed(motion, tau)
    theta = motion.theta + 0.5 * (motion.Omega + Omega) * tau
    cosine = math.cos(theta)
    sine = math.sin(theta)
    square = Omega * Omega
    return complex(square * cosine + motion.Omega_dot * sine, square * sine - motion.Omega_dot * cosine)


@kernel
def free_acceleration(motion: Motion, tau: float, unbalance: complex, q: Array, v: Array, a: Array) -> None:
    """Write the acceleration without contact into `a` (m/s^2), at `tau` (s) after the beginning of the step.

    `unbalance` is the `unbalance_direction` then.
    """
    n = q.shape[0]
    A, B = unbalance.real, unbalance.imag
    steady, cosine, sine = accelerations(motion)
    K, C = coefficients(motion)
    for i in range(n):
        a[i] = steady[i] + A * cosine[i] + B * sine[i]
    for j in range(n):
        K_j, C_j, q_j, v_j = K[j], C[j], q[j], v[j]
        for i in range(n):
            a[i] -= K_j[i] * q_j + C_j[i] * v_j
    if motion.Omega_dot != 0.0:
        delta_omega = motion.Omega_dot * tau
        for i in range(n):
            for j in range(n):
                a[i] -= delta_omega * motion.MinvG[i, j] * v[j]


@kernel
def input_power(motion: Motion, unbalance: complex, q: Array, v: Array) -> float:
    """Return the power (W) of all forces given as inputs, without passive bearings; `unbalance` is its direction."""
    power = 0.0
    A, B = unbalance.real, unbalance.imag
    steady, cosine, sine = forces(motion)
    for i in range(q.shape[0]):
        power += v[i] * (steady[i] + A * cosine[i] + B * sine[i])
    for bearing in motion.bearings:
        row = bearing.row
        power += bearing.gradient[0] * q[row] * v[row]
        power += bearing.gradient[1] * q[row + 1] * v[row + 1]
    return power


@kernel
def damping_power(motion: Motion, v: Array) -> float:
    """Return the heat per second from the passive bearings, the sum of c_b |v|^2 (W)."""
    power = 0.0
    for bearing in motion.bearings:
        row = bearing.row
        power += bearing.c_b * (v[row] * v[row] + v[row + 1] * v[row + 1])
    return power


@kernel
def quadratic_form(A: Array, x: Array) -> float:
    """Return x^T A x."""
    total = 0.0
    for i in range(x.shape[0]):
        row = 0.0
        for j in range(x.shape[0]):
            row += A[i, j] * x[j]
        total += x[i] * row
    return total
