"""Eigenvalues and eigenvectors of a rotor at a spin speed.

    (lambda^2 M + lambda (C + Omega G) + K + D) phi = 0                                           (1)

Hysteretic damping D depends on the frequency of the motion only through the sign of the difference between this
frequency and the spin speed (`hysteresis`). D has one constant value for all motion slower than the spin, and another
for all faster motion, so two linear problems contain all modes. An overdamped mode, which has no frequency, belongs to
a third problem with D at frequency 0.

A motion N that nothing holds (K N = 0) has the eigenvalue 0. This eigenvalue is double if nothing resists the velocity
of the motion either:

    multiplicity of 0  =  2 dim N - rank(L^T (C + Omega G) N),   L^T K = 0                          (2)

Rounding leaves a double eigenvalue up to 0.1 rad/s away from 0; therefore the smallest eigenvalues are set to 0, as
many as (2) states.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import eig, eigvals, svd

from amb_files.checks import require
from array_types import Array, Bools, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.hysteresis import Hysteresis

AT_REST = 0.03  # rad/s; rounding of K may change the square of an eigenvalue by the square of this
NEAR_ZERO = 1.0  # rad/s, within which an eigenvalue may be a 0 that is not exact
HELD = 1e-12  # of the largest stiffness, each row in proportion to its own, below which a motion is not held
RESISTED = 1e-9  # of the terms of a motion's resistance, below which it is rounding
FREQUENCY_SCALE = 1e3  # rad/s; scales velocities, so that both halves of the eigenproblem are of the same size
LIGHT = 1e-6  # of the inertia forces at that scale, below which stiffness and damping may be rounding
SHIFT = 0.01  # of `FREQUENCY_SCALE`, about which the slowest eigenvalues are; an unsupported rotor has several at 0
VALUES_OF_VIBRATION, VALUES_AT_REST = 4, 24  # eigenvalues computed for a vibration, and for motion without a frequency
FEWEST = 4  # times the computed eigenvalues, that a model has at least if not all are computed
LIGHTLY_DAMPED = 0.7  # damping ratio below which a mode is one of both problems
OF_LOSS = 2.0  # times the loss factor: largest |Im lambda / lambda| that a complex stiffness gives an overdamped mode


def eigenvalues(model: Matrices, Omega: float) -> Complex:
    """Return all eigenvalues (rad/s) of (1) at Omega (rad/s), shape (n,), including conjugate ones."""
    if model.hysteresis is None:
        return _with_zeros(_in_rad_per_s(eigvals(*_first_order(model, Omega))), model, Omega)
    values = eigenpairs(model, Omega)[0]
    return np.concatenate([values, values[values.imag > 0.0].conj()])


def slowest_eigenvalues(model: Matrices, Omega: float, count: int) -> Complex:
    """Return the eigenvalues (rad/s) of (1) nearest to zero at Omega (rad/s), including at least `count` vibrations.

    The method is Arnoldi's with inverse iteration (ARPACK); for a small model, or with hysteretic damping, all
    eigenvalues are computed. Slow vibrations that are strongly damped may be farther from zero.
    """
    from scipy.linalg import lu_factor, lu_solve
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    number = VALUES_OF_VIBRATION * count + VALUES_AT_REST
    if model.hysteresis is None and FEWEST * number < 2 * model.size:
        A, B = _first_order(model, Omega)
        factors = lu_factor(A - SHIFT * B)
        inverse = LinearOperator(A.shape, matvec=lambda v: lu_solve(factors, B @ v), dtype=np.float64)
        start = np.random.default_rng(0).standard_normal(len(A))  # alike in x and y, it would miss half of equal pairs
        try:
            nearest = eigs(inverse, number, v0=start, return_eigenvectors=False)
        except ArpackNoConvergence:
            return eigenvalues(model, Omega)
        values = _with_zeros(_in_rad_per_s(SHIFT + 1.0 / nearest), model, Omega)
        if np.sum(oscillating(values) & (values.imag > 0.0)) >= count:
            return values
    return eigenvalues(model, Omega)


def eigenpairs(model: Matrices, Omega: float, omega: float | None = None) -> tuple[Complex, Complex]:
    """Return the eigenvalues (rad/s) and eigenvectors of (1), with the vectors in columns.

    All eigenvalues that are real or have Im lambda > 0 are included; with hysteretic damping, their conjugates are left
    out.

    Parameters
    ----------
    model
        A model with its bearings.
    Omega
        Spin speed (rad/s), positive from x to y.
    omega
        Frequency (rad/s) at which D is computed; by default that of each mode.

    Raises
    ------
    ValueError
        If Omega is not finite.
    """
    loss = model.hysteresis
    if loss is None:
        return _solved(model, Omega)
    if omega is not None:
        return _solved(model, Omega, loss.stiffness(omega, Omega))
    return _by_frequency(model, loss, Omega)


def oscillating(values: Complex) -> Bools:
    """Return which eigenvalues (rad/s) belong to oscillating motion."""
    return np.isfinite(values) & (np.abs(values.imag) > np.maximum(AT_REST, 1e-6 * np.abs(values)))


def _by_frequency(model: Matrices, loss: Hysteresis, Omega: float) -> tuple[Complex, Complex]:
    """Return the overdamped modes, the modes that are slower than the spin, and the modes that are faster.

    Near the spin speed, a mode may be slower than the spin in one problem and faster in the other. A lightly damped
    mode is therefore taken from the problem of faster motion if it is not among the first n such modes there. Here n is
    the number of lightly damped modes in the other problem that are slower than the spin.
    """
    spin = abs(Omega)
    values, vectors = _solved(model, Omega, loss.stiffness(0.0, Omega))
    real = np.isfinite(values) & ~oscillating(values)
    parts = [(values[real], vectors[:, real])]
    n_slower = 0
    if spin > 0.0:
        values, vectors = _with_frequency(model, Omega, loss, 0.5 * spin)
        slower = values.imag < spin
        n_slower = int(np.sum(_is_light(values) & slower))
        parts.append((values[slower], vectors[:, slower]))
    values, vectors = _with_frequency(model, Omega, loss, math.inf)
    light = _is_light(values)
    faster = np.where(light, np.cumsum(light) > n_slower, values.imag >= spin)
    parts.append((values[faster], vectors[:, faster]))
    return np.concatenate([part[0] for part in parts]), np.hstack([part[1] for part in parts])


def _with_frequency(model: Matrices, Omega: float, loss: Hysteresis, omega: float) -> tuple[Complex, Complex]:
    """Return the eigenpairs with Im lambda > 0, computed with D at a frequency, by ascending Im lambda."""
    D = loss.stiffness(omega, Omega)
    values, vectors = _solved(model, Omega, D)
    least = OF_LOSS * loss.loss_factor if np.iscomplexobj(D) else 0.0
    upper = np.flatnonzero(oscillating(values))
    upper = upper[values[upper].imag > least * np.abs(values[upper])]
    upper = upper[np.argsort(values[upper].imag, kind="stable")]
    return values[upper], vectors[:, upper]


def _is_light(values: Complex) -> Bools:
    return np.asarray(np.abs(values.real) < LIGHTLY_DAMPED * np.abs(values))


def _solved(model: Matrices, Omega: float, D: Array | Complex | None = None) -> tuple[Complex, Complex]:
    values, vectors = eig(*_first_order(model, Omega, D))
    return _with_zeros(_in_rad_per_s(values), model, Omega, D), vectors[: model.size]


def _with_zeros(values: Complex, model: Matrices, Omega: float, D: Array | Complex | None = None) -> Complex:
    """Return the eigenvalues, with as many of the smallest set to 0 as (2) requires."""
    if np.abs(values).min(initial=math.inf) < NEAR_ZERO:
        values[np.argsort(np.abs(values), kind="stable")[: _multiplicity_of_zero(model.at(Omega), Omega, D)]] = 0.0
    return values


def _multiplicity_of_zero(model: Matrices, Omega: float, D: Array | Complex | None) -> int:
    K, resistance = model.K if D is None else model.K + D, model.C + Omega * model.G
    scale = np.sqrt(np.abs(np.diag(K)))
    scale[scale == 0.0] = 1.0
    left, stiffness, right = svd(K / scale / scale[:, None])
    free = stiffness <= HELD * stiffness[0]
    L, N = left[:, free] / scale[:, None], right[free].conj().T / scale[:, None]
    terms = np.abs(L).T @ np.abs(resistance) @ np.abs(N)
    rank = np.linalg.matrix_rank(L.conj().T @ resistance @ N, tol=RESISTED * terms.max()) if terms.any() else 0
    return 2 * int(free.sum()) - int(rank)


def _first_order(
    model: Matrices, Omega: float, D: Array | Complex | None = None
) -> tuple[Array | Complex, Array | Complex]:
    """Return A and B of A z = (lambda / w) B z, z = (q, q' / w), scaled by a frequency w and the largest force term."""
    require(bool(np.isfinite(Omega)), "Omega", f"{Omega} rad/s", "finite")
    model = model.at(Omega)
    w, K, resistance = FREQUENCY_SCALE, model.K if D is None else model.K + D, model.C + Omega * model.G
    sizes = (np.linalg.norm(model.K, 1), w * np.linalg.norm(resistance, 1), LIGHT * w**2 * np.linalg.norm(model.M, 1))
    force = float(max(sizes)) or 1.0
    identity, zero = np.eye(model.size), np.zeros((model.size, model.size))
    A = np.block([[zero, identity], [-K / force, -resistance * (w / force)]])
    B = np.block([[identity, zero], [zero, model.M * (w**2 / force)]])
    return A, B


def _in_rad_per_s(values: Complex) -> Complex:
    # Part by part: a mass matrix that is nearly singular has infinite eigenvalues, and inf times 0 would be NaN.
    return np.asarray((np.ascontiguousarray(values).view(np.float64) * FREQUENCY_SCALE).view(np.complex128))
