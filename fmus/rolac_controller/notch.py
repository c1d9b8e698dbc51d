"""Generalised notch and synchronous force rejection: what magnetic bearings commonly do about unbalance.

Neither reduces the vibration; they take the bearing's answer to it away. The synchronous control force of an axis is
E = U - C q_b, with C the PID's response (`pid.response`) and q_b the synchronous displacement at the bearing; with
q_b = q_0 + R_b U it is E = E_0 + S^-1 U, S^-1 = I - C R_b, and

    U' = -alpha S (U - C q_b)

takes it to zero with the rate alpha: the current has no synchronous part any more. R. Herzog, P. Buehler, C. Gaehler
and R. Larsonneur, "Unbalance compensation using generalized notch filters in the multivariable feedback of magnetic
bearings", IEEE Trans. Control Systems Technology 4 (1996). With C - K_s in place of C it is the whole force of the
bearing, K_s x + K_i I, that vanishes: the rotor turns about its principal axis of inertia.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.interface import DERIVATIVE_TIME, DIRECT, GAINS, K_S, N_GAINS, SAMPLE_TIME
from rolac_controller.names import N_AXES, SENSOR_OF_AXIS
from rolac_controller.pid import response

COLUMNS = N_AXES + 1  # of the equations S^-1 x = E, the right-hand side last
N_SCRATCH = 2 * N_AXES * COLUMNS
SINGULAR = 1e-9  # pivot below which there is no solution; the matrix is of order one


@kernel
def reject(
    parameters: Array, receptance: Array, omega: float, gain: float, whole: bool, q: Array, force: Array, a: Array
) -> None:
    """One step of U' = -alpha S (U - C q_b).

    Parameters
    ----------
    receptance
        R at this speed, as `stored` holds it (m/N).
    omega
        Frequency of the harmonic (rad/s).
    gain
        alpha times the sample time.
    whole
        Whether the whole force of the bearing is to vanish, in place of the current.
    q, force
        Displacements (m) and forces (N) of the harmonic, re and im; `force` is changed.
    a
        Scratch, shape (N_SCRATCH,).
    """
    direct, tau, h = parameters[DIRECT] != 0.0, parameters[DERIVATIVE_TIME], parameters[SAMPLE_TIME]
    for i in range(N_AXES):
        c_re, c_im = response(parameters[GAINS + i * N_GAINS : GAINS + (i + 1) * N_GAINS], direct, tau, h, omega)
        if whole:
            c_re -= parameters[GAINS + i * N_GAINS + K_S]
        s = SENSOR_OF_AXIS[i]
        for j in range(N_AXES):
            r_re, r_im = receptance[2 * (s * N_AXES + j)], receptance[2 * (s * N_AXES + j) + 1]
            at = 2 * (i * COLUMNS + j)
            a[at] = (1.0 if i == j else 0.0) - (c_re * r_re - c_im * r_im)
            a[at + 1] = -(c_re * r_im + c_im * r_re)
        at = 2 * (i * COLUMNS + N_AXES)
        a[at] = force[2 * i] - (c_re * q[2 * s] - c_im * q[2 * s + 1])
        a[at + 1] = force[2 * i + 1] - (c_re * q[2 * s + 1] + c_im * q[2 * s])
    if solve(a):
        for i in range(N_AXES):
            at = 2 * (i * COLUMNS + N_AXES)
            force[2 * i] -= gain * a[at]
            force[2 * i + 1] -= gain * a[at + 1]


@kernel
def solve(a: Array) -> bool:
    """Solve the equations in `a` by elimination with pivoting; the solution is left in their last column."""
    for p in range(N_AXES):
        best, largest = p, 0.0
        for i in range(p, N_AXES):
            size = math.hypot(a[2 * (i * COLUMNS + p)], a[2 * (i * COLUMNS + p) + 1])
            if size > largest:
                best, largest = i, size
        if largest < SINGULAR:
            return False
        for k in range(2 * COLUMNS):
            a[2 * p * COLUMNS + k], a[2 * best * COLUMNS + k] = a[2 * best * COLUMNS + k], a[2 * p * COLUMNS + k]
        pivot = 2 * (p * COLUMNS + p)
        d_re, d_im = a[pivot] / (largest * largest), -a[pivot + 1] / (largest * largest)
        for k in range(COLUMNS):
            at = 2 * (p * COLUMNS + k)
            a[at], a[at + 1] = a[at] * d_re - a[at + 1] * d_im, a[at] * d_im + a[at + 1] * d_re
        for i in range(N_AXES):
            if i == p:
                continue
            f_re, f_im = a[2 * (i * COLUMNS + p)], a[2 * (i * COLUMNS + p) + 1]
            for k in range(COLUMNS):
                at, of_pivot = 2 * (i * COLUMNS + k), 2 * (p * COLUMNS + k)
                a[at] -= f_re * a[of_pivot] - f_im * a[of_pivot + 1]
                a[at + 1] -= f_re * a[of_pivot + 1] + f_im * a[of_pivot]
    return True
