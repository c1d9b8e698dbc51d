"""Generalised notch and synchronous force rejection: what magnetic bearings commonly do about unbalance.

Neither reduces the vibration; they remove the bearing's response to it. The synchronous control force of an axis is
E = U - C q_b, with C the PID's response (`pid.response`) and q_b the synchronous displacement at the bearing; with
q_b = q_0 + R_b U it is E = E_0 + S^-1 U, S^-1 = I - C R_b, and

    U' = -alpha S (U - C q_b)

takes it to zero with the rate alpha: the current has no synchronous part any more. R. Herzog, P. Buehler, C. Gaehler
and R. Larsonneur, "Unbalance compensation using generalized notch filters in the multivariable feedback of magnetic
bearings", IEEE Trans. Control Systems Technology 4 (1996). With C - K_s in place of C it is the whole force of the
bearing, K_s x + K_i I, that vanishes: the rotor turns about its principal axis of inertia.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from rolac_controller.complex_numbers import Complex, divided
from rolac_controller.enumerations import FORCE_FREE
from rolac_controller.pid import response
from rolac_controller.records import Parameters
from rolac_controller.state import Work

SINGULAR = 1e-9  # pivot below which there is no solution; the matrix is of order one


@kernel
def reject_synchronous(parameters: Parameters, omega: float, Q: Complex, U: Complex, work: Work) -> None:
    """Change the forces of a harmonic by one step of U' = -alpha S (U - C q_b).

    Parameters
    ----------
    parameters
        With `rolac.mode` FORCE_FREE it is the whole force of the bearing that vanishes.
    omega
        Frequency of the harmonic (rad/s).
    Q
        Synchronous displacements of the harmonic, shape (n_sensors,) (m).
    U
        Forces of the harmonic, shape (n_axes,) (N); changed.
    work
        With the receptance R at this speed (m/N); its `inverse_S` and `E` are overwritten.
    """
    own, n_axes = parameters.own[0], U.shape[0]
    direct, tau, h = own.pid.direct, own.derivative_time, own.sample_time
    R, inverse_S, E = work.R, work.inverse_S, work.E
    for i in range(n_axes):
        gains, s = parameters.axes[i], int(parameters.sensor_of_axis[i])
        C = response(gains, direct, tau, h, omega)
        if own.rolac.mode == FORCE_FREE:
            C -= gains.k_s
        for j in range(n_axes):
            inverse_S[i, j] = (1.0 if i == j else 0.0) - C * R[s, j]
        E[i] = U[i] - C * Q[s]
    if solve_in_place(inverse_S, E):
        for i in range(n_axes):
            U[i] -= own.rolac.alpha * own.sample_time * E[i]


@kernel
def solve_in_place(A: Complex, b: Complex) -> bool:
    """Solve A x = b by elimination with pivoting; return whether there is a solution.

    Parameters
    ----------
    A
        Matrix, shape (n_axes, n_axes); overwritten.
    b
        Right-hand side, shape (n_axes,); receives the solution.
    """
    n_axes = b.shape[0]
    for p in range(n_axes):
        pivot_row, largest = p, 0.0
        for i in range(p, n_axes):
            size = abs(A[i, p])
            if size > largest:
                pivot_row, largest = i, size
        if largest < SINGULAR:
            return False
        for k in range(n_axes):
            A[p, k], A[pivot_row, k] = A[pivot_row, k], A[p, k]
        b[p], b[pivot_row] = b[pivot_row], b[p]
        scale = divided(A[p, p].conjugate(), largest * largest)
        for k in range(n_axes):
            A[p, k] *= scale
        b[p] *= scale
        for i in range(n_axes):
            if i != p:
                factor = A[i, p]
                for k in range(n_axes):
                    A[i, k] -= factor * A[p, k]
                b[i] -= factor * b[p]
    return True
