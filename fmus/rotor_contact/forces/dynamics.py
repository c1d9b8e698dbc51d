"""Acceleration of the shaft without contact; everything that is constant over a step is collected once per step.

docs/theory/rotor.md states the equation of motion, with rotating damping. The spin supplies the work of the rotating
damping: above a critical speed, the force R J q of this damping drives the rotor into forward whirl.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.forces.passive_bearings import Bearings, add_bearings, heat_per_second, set_passive
from rotor_contact.shaft.products import dot, quadratic_form, subtract_products
from rotor_contact.shaft.seals import Seals, add_seals
from rotor_contact.shaft.structure import REAL, Structure
from rotor_contact.variables.signals import Inputs, Parameters

N_ROWS = 10  # of a motion, beyond its coefficients
LEAST_SPEED_GAIN = 1e-4  # rad/s; a smaller gain is neglected: it turns velocities by < 1e-7 rad in a millisecond
ROUNDING = 1e-13  # relative; speeds and gradients that differ by less count as unchanged


class Excitation(NamedTuple):
    """Steady part, cosine part and sine part of forces (N) or of accelerations (m/s^2), shape (n,) each.

    Their sum is steady + A cosine + B sine, where A + i B = exp(i theta) (Omega^2 - i Omega') is the acceleration of a
    unit unbalance. `without_magnets` is the steady part without the magnets' share.
    """

    steady: Array
    cosine: Array
    sine: Array
    without_magnets: Array


class Coefficients(NamedTuple):
    """The columns of K = M^-1 (K - Omega R J - gradients + passive bearings and seals), C = M^-1 (C + R + Omega G).

    Shape (n, n) each; row j of an array holds column j of its matrix, so that products access contiguous memory. Omega
    is the speed at the beginning of the step.
    """

    K_columns: Array
    C_columns: Array


class SpinCoupling(NamedTuple):
    """Coupling of the shaft to a free spin, shape (n,) each; see `bodies`."""

    # Force on the shaft (N) that opposes a unit angular acceleration of the spin; also the torque on the spin that
    # opposes a unit q''.
    p: Array
    s: Array  # M^-1 p, scaled by 1/sqrt(J - p^T M^-1 p)


class Motion(NamedTuple):
    """Coefficients of q'' = steady + A cosine + B sine - K q - C q' during one step (see `Excitation`).

    `coefficients`, `accelerations`, `forces` and `spin_coupling` are views into `rows`. They share one array because
    all kernels of a step pass this tuple on, and each additional array would slow down every call.
    """

    rows: Array  # shape (N_ROWS + 2 n, n)
    bearings: Bearings
    over_speed: Array  # the coefficients' dependence on the speed within the step (see `Structure`), shape (2 n, n)
    is_damped: bool  # whether the shaft has material damping, or there are seals
    seals: Seals
    theta: float  # rotor angle at the beginning of the step (rad)
    Omega: float  # spin speed there (rad/s)
    Omega_dot: float  # spin acceleration (rad/s^2), 0 if the spin is a degree of freedom


@views
def coefficients(motion: Motion) -> Coefficients:
    """Return K and C of a motion."""
    n = motion.rows.shape[1]
    return Coefficients(motion.rows[:n], motion.rows[n : 2 * n])


@views
def accelerations(motion: Motion) -> Excitation:
    """Return the accelerations due to all excitation forces."""
    n = motion.rows.shape[1]
    return Excitation(motion.rows[2 * n], motion.rows[2 * n + 1], motion.rows[2 * n + 2], motion.rows[2 * n + 9])


@views
def forces(motion: Motion) -> Excitation:
    """Return the forces that cause these accelerations."""
    n = motion.rows.shape[1]
    return Excitation(motion.rows[2 * n + 3], motion.rows[2 * n + 4], motion.rows[2 * n + 5], motion.rows[2 * n + 8])


@views
def spin_coupling(motion: Motion) -> SpinCoupling:
    """Return the coupling of shaft and free spin by unbalance."""
    n = motion.rows.shape[1]
    return SpinCoupling(motion.rows[2 * n + 6], motion.rows[2 * n + 7])


@views
def motion_of(
    structure: Structure, rows: Array, bearings: Bearings, theta: float, Omega: float, Omega_dot: float
) -> Motion:
    """Return a motion that uses the memory `rows` and `bearings`; `theta` to `Omega_dot` are its initial values."""
    return Motion(rows, bearings, structure.over_speed, structure.is_damped, structure.seals, theta, Omega, Omega_dot)


@views
def motion_at(motion: Motion, theta: float, Omega: float) -> Motion:
    """Return the same motion at another angle and speed; its coefficients still apply to the beginning of the step."""
    return Motion(
        motion.rows, motion.bearings, motion.over_speed, motion.is_damped, motion.seals, theta, Omega, motion.Omega_dot
    )


@kernel
def set_bearings(parameters: Parameters, motion: Motion) -> None:
    """Set the passive bearings of a motion; the magnets do not exert forces yet."""
    given = forces(motion)
    copy(given.without_magnets, given.steady)
    for k in range(motion.bearings.shape[0]):
        set_passive(motion.bearings[k], parameters.bearings[k])


@kernel
def add_magnetic_forces(inputs: Inputs, motion: Motion) -> None:
    """Add the forces of the magnetic bearings to the forces of a motion.

    Bearing force on the rotor, for each axis: F + k_xx (x - x_ref) - k_b x - c_b x'.
    """
    steady = forces(motion).steady
    for k in range(motion.bearings.shape[0]):
        bearing = motion.bearings[k]
        for i in range(2):
            axis = inputs.axes[2 * k + i]
            bearing.gradient[i] = axis.gradient
            steady[bearing.row + i] += axis.force - axis.gradient * axis.reference


@noinline_kernel
def collect_coefficients(structure: Structure, motion: Motion) -> None:
    """Write the coefficients and the steady accelerations of a step (3.13)."""
    n = structure.K.shape[0]
    K, C = coefficients(motion)
    for i in range(n):
        for j in range(n):
            K[j, i] = structure.MinvK[i, j] - motion.Omega * structure.over_speed[n + i, j]
            C[j, i] = structure.MinvC[i, j] + motion.Omega * structure.over_speed[i, j]
    add_bearings(structure.Minv, motion.bearings, 1.0, K, C)
    add_seals(motion.seals, motion.Omega, K, C)
    divide_by_mass(structure.Minv, forces(motion).steady, accelerations(motion).steady)


@kernel
def divide_by_mass(Minv: Array, force: Array, acceleration: Array) -> None:
    """Write M^-1 force into `acceleration`."""
    n = force.shape[0]
    for i in range(n):
        acceleration[i] = 0.0
    for j in range(n):
        if force[j] != 0.0:
            for i in range(n):
                acceleration[i] += Minv[j, i] * force[j]


@kernel
def unbalance_direction(theta: float, Omega: float, Omega_dot: float) -> complex:
    """Return A + i B = exp(i theta) (Omega^2 - i Omega') (rad^2/s^2) of a unit unbalance."""
    cosine = math.cos(theta)
    sine = math.sin(theta)
    square = Omega * Omega
    return complex(square * cosine + Omega_dot * sine, square * sine - Omega_dot * cosine)


@kernel
def free_acceleration(motion: Motion, speed_gain: float, unbalance: complex, q: Array, v: Array, a: Array) -> None:
    """Write the shaft's acceleration without contact into the first n of `a` (m/s^2).

    `speed_gain` is the change of the spin speed (rad/s) since the beginning of the step, and `unbalance` is the present
    `unbalance_direction`.
    """
    n = motion.rows.shape[1]
    A, B = unbalance.real, unbalance.imag
    steady, cosine, sine, _ = accelerations(motion)
    K, C = coefficients(motion)
    for i in range(n):
        a[i] = steady[i] + A * cosine[i] + B * sine[i]
    subtract_products(K, q, C, v, a)
    if abs(speed_gain) > LEAST_SPEED_GAIN:
        for i in range(n):
            change = dot(motion.over_speed[i], v[:n])
            if motion.is_damped:
                change -= dot(motion.over_speed[n + i], q[:n])
            a[i] -= speed_gain * change


@kernel
def input_power(motion: Motion, unbalance: complex, q: Array, v: Array) -> float:
    """Return the power (W) of all input forces on the shaft, without passive bearings.

    `unbalance` is the direction of the unbalance, or 0 if the work of the unbalance does not count as work of the
    inputs.
    """
    power = 0.0
    A, B = unbalance.real, unbalance.imag
    steady, cosine, sine, _ = forces(motion)
    for i in range(steady.shape[0]):
        power += v[i] * (steady[i] + A * cosine[i] + B * sine[i])
    for bearing in motion.bearings:
        row = bearing.row
        power += bearing.gradient[0] * q[row] * v[row]
        power += bearing.gradient[1] * q[row + 1] * v[row + 1]
    return power


@kernel
def damping_power(motion: Motion, v: Array) -> float:
    """Return the dissipation (W) of the passive bearings at the velocities v (m/s)."""
    power = 0.0
    for bearing in motion.bearings:
        row = bearing.row
        power += heat_per_second(bearing, v[row], v[row + 1])
    return power


@kernel
def shaft_damping(forms: Array, Omega: float, q: Array, v: Array) -> tuple[float, float]:
    """Return the dissipation (W) of the shaft's damping and its torque (N m) on the spin.

    With the velocity relative to the rotating shaft, w = v - Omega J q: heat = v^T C v + w^T R w, torque = (J q)^T R w.
    The rows of C and R are read instead of the columns, because both matrices are symmetric. Eight sums are computed at
    once.
    """
    n = forms.shape[1]
    heat = quadratic_form(forms[n : 2 * n], v) if is_damped_to_ground(forms) else 0.0
    torque = 0.0
    i = 0
    while i + 8 <= n:
        a = b = c = d = e = f = g = h = 0.0
        for j in range(n):
            w, R = v[j] - Omega * _turned(q, j), part(forms, (2 * n + j) * n + i, REAL, 8)
            a += R[0] * w
            b += R[1] * w
            c += R[2] * w
            d += R[3] * w
            e += R[4] * w
            f += R[5] * w
            g += R[6] * w
            h += R[7] * w
        x, y = part(v, i, REAL, 8), part(q, i, REAL, 8)
        heat += (x[0] * a + x[1] * b) + (x[2] * c + x[3] * d)
        heat += (x[4] * e + x[5] * f) + (x[6] * g + x[7] * h)
        torque += (y[0] * b - y[1] * a) + (y[2] * d - y[3] * c) + (y[4] * f - y[5] * e) + (y[6] * h - y[7] * g)
        i += 8
    while i < n:
        rotating = 0.0
        for j in range(n):
            rotating += forms[2 * n + j, i] * (v[j] - Omega * _turned(q, j))
        heat += v[i] * rotating
        torque += _turned(q, i) * rotating
        i += 1
    return heat - Omega * torque, torque


@kernel
def is_damped_to_ground(forms: Array) -> bool:
    """Return whether there is non-rotating damping; because C is positive semidefinite, its diagonal shows this."""
    n = forms.shape[1]
    for i in range(n):
        if forms[n + i, i] != 0.0:
            return True
    return False


@kernel
def _turned(q: Array, j: int) -> float:
    """Return component j of J q."""
    component: float = q[j - 1] if j % 2 else -q[j + 1]
    return component
