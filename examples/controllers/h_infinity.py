"""H-infinity control of the compressor by mixed sensitivity, on the sampled linear model, without slycot.

    min_K || [W_s S; W_u K S] [1/2, G] ||,  S = (1 - G K)^-1,  G = plant times gain

Currents disturb the rotor, and readings have half the weight of those: a controller for readings alone would cancel
the bending modes, which nothing damps, in place of damping them. G is the plant with held currents, in the plane
w = (2/T) (z - 1)/(z + 1), from which Tustin's method leads back to z: norm and stability are those of the sampled loop.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import control
import numpy as np
from lqg import AXES, DEMANDS, SAMPLE_TIME, SCENARIO, design_model
from numpy.typing import NDArray
from scipy.linalg import block_diag, matrix_balance, solve_continuous_are

import amb_cosim

GAIN = 4e4  # A/m, where displacements and currents count the same
READINGS = 0.5  # weight of what disturbs the readings, over that of disturbing currents
HERTZ = 2.0 * np.pi
W_S = control.tf([2.0 / (10.0 * HERTZ), 2.0], np.polymul([2.0 / (10.0 * HERTZ), 1.0], [1.0 / (2000.0 * HERTZ), 1.0]))
W_U = control.tf([1.0 / (1000.0 * HERTZ), 1.0], [1.0 / (3000.0 * HERTZ), 1.0])  # from 1 to 3
SUBOPTIMAL = 1.1  # of the least norm
CLOSE = 1e-3  # to which that is found

Array = NDArray[np.float64]


class Problem(NamedTuple):
    """x' = A x + B1 w + B2 u, z = C1 x + D12 u, y = C2 x + D21 w + D22 u: least norm from w to z under u = K y."""

    A: Array
    B1: Array
    B2: Array
    C1: Array
    C2: Array
    D12: Array
    D21: Array
    D22: Array


def h_infinity(scenario: Any = SCENARIO) -> tuple[Any, float]:
    """Return the controller u = gain K y, and the bound of the norm that it keeps."""
    plant = design_model(scenario)
    problem = mixed_sensitivity(*control.ssdata(control.sample_system(plant, SAMPLE_TIME, "zoh"))[:3])
    norm = SUBOPTIMAL * least_norm(problem)
    A, B, C = central_controller(problem, norm)
    law = control.ss(A, B, GAIN * C, np.zeros((len(C), len(B.T))))
    return amb_cosim.linear_controller(law, AXES, DEMANDS, SAMPLE_TIME, limits=(-6.5, 5.0)), norm


def mixed_sensitivity(A: Array, B: Array, C: Array) -> Problem:
    """Return the problem of a sampled plant with the weights: w is currents and readings, z is W_s y and W_u u."""
    A, B, C, D = in_w(A, GAIN * B, C, SAMPLE_TIME)
    m, p, n = len(B.T), len(C), len(A)
    (As, Bs, Cs, _), (Au, Bu, Cu, Du) = (
        [np.kron(np.eye(size), matrix) for matrix in control.ssdata(control.ss(weight))]
        for weight, size in ((W_S, p), (W_U, m))
    )
    ns, nu = len(As), len(Au)
    whole = np.block([[A, np.zeros((n, ns + nu))], [Bs @ C, As, np.zeros((ns, nu))], [np.zeros((nu, n + ns)), Au]])
    size = matrix_balance(whole, permute=False, separate=True)[1][0][:, None]
    disturbed = np.vstack([np.hstack([B, np.zeros((n, p))]), Bs @ np.hstack([D, READINGS * np.eye(p)])])
    return Problem(
        whole * size.T / size,
        np.vstack([disturbed, np.zeros((nu, m + p))]) / size,
        np.vstack([B, Bs @ D, Bu]) / size,
        np.hstack([np.zeros((p + m, n)), block_diag(Cs, Cu)]) * size.T,
        np.hstack([C, np.zeros((p, ns + nu))]) * size.T,
        np.vstack([np.zeros((p, m)), Du]),
        np.hstack([D, READINGS * np.eye(p)]),
        D,
    )


def least_norm(problem: Problem) -> float:
    """Return the least norm that some controller keeps, by bisection."""
    low, high = 1e-3, 1e3
    while high > low * (1.0 + CLOSE):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if riccati(problem, middle) is None else (low, middle)
    return float(high)


def riccati(problem: Problem, norm: float) -> tuple[Array, Array] | None:
    """Return X and Y of the norm; None if no controller keeps it."""
    A, B1, B2, C1, C2, D12, D21, _ = problem
    worst = -(norm**2)
    controlled = block_diag(worst * np.eye(len(B1.T)), D12.T @ D12)
    observed = block_diag(worst * np.eye(len(C1)), D21 @ D21.T)
    across = np.hstack([np.zeros_like(B1), C1.T @ D12]), np.hstack([np.zeros_like(C1.T), B1 @ D21.T])
    try:
        X = solve_continuous_are(A, np.hstack([B1, B2]), C1.T @ C1, controlled, s=across[0])
        Y = solve_continuous_are(A.T, np.hstack([C1.T, C2.T]), B1 @ B1.T, observed, s=across[1])
    except np.linalg.LinAlgError:
        return None
    definite = all(np.linalg.eigvalsh(Q).min() > -1e-9 * np.abs(Q).max() for Q in (X, Y))
    return (X, Y) if definite and np.abs(np.linalg.eigvals(X @ Y)).max() < norm**2 else None


def central_controller(problem: Problem, norm: float) -> tuple[Array, Array, Array]:
    """Return A, B, C of the controller in the middle of all that keep a norm.

    x' = A x + B1 w + B2 u + Z L (C2 x + D21 w + D22 u - y)
    u = F x,  w = B1^T X x / norm^2,  Z = (1 - Y X / norm^2)^-1

    J. C. Doyle, K. Glover, P. P. Khargonekar, B. A. Francis, State-space solutions to standard H2 and H-infinity
    control problems, IEEE Trans. Automatic Control 34 (1989) 831-847; with D12^T C1 and B1 D21^T other than zero, K.
    Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control (1996), chapter 17.
    """
    A, B1, B2, C1, C2, D12, D21, D22 = problem
    solved = riccati(problem, norm)
    if solved is None:
        raise ValueError(f"no controller keeps a norm of {norm:g}")
    X, Y = solved
    F = -np.linalg.solve(D12.T @ D12, B2.T @ X + D12.T @ C1)
    L = -np.linalg.solve(D21 @ D21.T, (Y @ C2.T + B1 @ D21.T).T).T
    ZL = np.linalg.solve(np.eye(len(A)) - Y @ X / norm**2, L)
    worst = B1.T @ X / norm**2
    return A + B1 @ worst + B2 @ F + ZL @ (C2 + D21 @ worst + D22 @ F), -ZL, F


def in_w(A: Array, B: Array, C: Array, T: float) -> tuple[Array, Array, Array, Array]:
    """Return a sampled system without direct term in the plane of w, its states scaled to like sizes."""
    scale = matrix_balance(A, permute=False, separate=True)[1][0]
    A, B, C = A * scale / scale[:, None], B / scale[:, None], C * scale
    half = np.linalg.inv(np.eye(len(A)) + A)
    return 2.0 / T * half @ (A - np.eye(len(A))), half @ B, 4.0 / T * C @ half, -C @ half @ B


if __name__ == "__main__":
    controller, norm = h_infinity()
    print(controller.save("h_infinity.npz"), f"norm below {norm:.2f}")
