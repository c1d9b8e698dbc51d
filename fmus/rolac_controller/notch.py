"""Generalised notch and synchronous force rejection, two common control laws against the effects of unbalance.

Neither law reduces the vibration; both remove the bearing's response to it. The synchronous control force is E = U - C
Q, where C is the response of the loop's controller and Q contains the synchronous displacements at the sensors. C is
the sum of the responses of the PID (`pid.response`), which acts on the sensor of each axis, and of an additional
controller (`inner_loop`). With Q = Q_0 + R U, it follows that E = E_0 + S^-1 U, where S^-1 = I - C R. The law

    U' = -alpha S (U - C Q)

reduces E to zero at the rate alpha. The current then has no synchronous part. R. Herzog, P. Buehler, C. Gaehler and R.
Larsonneur, "Unbalance compensation using generalized notch filters in the multivariable feedback of magnetic bearings",
IEEE Trans. Control Systems Technology 4 (1996). If C - K_s replaces C, the whole bearing force K_s x + K_i I vanishes.
The rotor then rotates about its principal axis of inertia.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.parts import clear
from rolac_controller.complex_numbers import Complex, divided
from rolac_controller.enumerations import FORCE_FREE
from rolac_controller.pid import response
from rolac_controller.receptance_table import MISSING, find_bracket, interpolate
from rolac_controller.records import Parameters
from rolac_controller.state import Work

SINGULAR = 1e-9  # pivot below which the system is singular; the matrix is of order 1


@kernel
def control_response(parameters: Parameters, order: float, Omega: float, C: Complex) -> None:
    """Compute the matrix C of the complete controller at a harmonic, u = -C q, shape (n_axes, n_sensors) (N/m).

    Parameters
    ----------
    order, Omega
        Order of the harmonic, and spin speed (rad/s).
    C
        Receives the result; if `rolac.mode` is FORCE_FREE, K_s is subtracted, so that -C q is the whole force of the
        bearing.
    """
    common, inner = parameters.common[0], parameters.inner
    bracket = find_bracket(inner, order, Omega)
    if bracket.coverage == MISSING:
        clear(C)
    else:
        interpolate(inner.C[bracket.lower], inner.C[bracket.upper], bracket.weight, C)
    for i in range(C.shape[0]):
        gains, s = parameters.axes[i], int(parameters.sensor_of_axis[i])
        C[i, s] += response(gains, common.pid.direct, common.derivative_time, common.sample_time, order * Omega)
        if common.rolac.mode == FORCE_FREE:
            C[i, s] -= gains.k_s


@kernel
def reject_synchronous(parameters: Parameters, order: float, Omega: float, Q: Complex, U: Complex, work: Work) -> None:
    """Change the forces of a harmonic by one step of the law U' = -alpha S (U - C Q).

    Parameters
    ----------
    parameters
        Parameters of the controller; if `rolac.mode` is FORCE_FREE, the whole force of the bearing is reduced to zero.
    order, Omega
        Order of the harmonic, and spin speed (rad/s).
    Q
        Synchronous displacements of the harmonic, shape (n_sensors,) (m).
    U
        Forces of the harmonic, shape (n_axes,) (N); changed.
    work
        Contains the receptance R at this speed (m/N); its `C`, `inverse_S` and `E` are overwritten.
    """
    common, n_axes = parameters.common[0], U.shape[0]
    R, C, inverse_S, E = work.R, work.C, work.inverse_S, work.E
    control_response(parameters, order, Omega, C)
    for i in range(n_axes):
        for j in range(n_axes):
            total = 0j
            for s in range(C.shape[1]):
                total += C[i, s] * R[s, j]
            inverse_S[i, j] = (1.0 if i == j else 0.0) - total
        total = 0j
        for s in range(C.shape[1]):
            total += C[i, s] * Q[s]
        E[i] = U[i] - total
    if solve_in_place(inverse_S, E):
        for i in range(n_axes):
            U[i] -= common.rolac.alpha * common.sample_time * E[i]


@kernel
def solve_in_place(A: Complex, b: Complex) -> bool:
    """Solve A x = b by elimination with pivoting; return whether the system is solvable.

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
