"""The slow modes of a sampled law, which wind up when a demand is limited.

The law is split by A = [V V_f] diag(A_s, A_f) [W; W_f], where A_s contains the modes with |lambda| >= alpha = exp(-T /
slow_time). The split uses an ordered real Schur form and a Sylvester equation. With C_s = C V and F = A_s / alpha,
whose modes are all outside the unit circle,

    X = F^-T (X + C_s^T C_s) F^-1,    P = X^-1                                         (1)
    L = alpha V F P C_s^T (C_s P C_s^T + 1)^-1                                         (2)

is the gain of the Kalman filter for F without process noise, so A_s - W L C_s has the modes alpha^2 / conj(lambda). B.
D. O. Anderson and J. B. Moore, Optimal Filtering, 1979, chapter 4, with a prescribed degree of stability as in their
Optimal Control, 1990. Modes that cannot be observed from the demands are not included, and neither are modes that are
much less observable than others. Independent groups of states are first brought to a common scale, because their units
may differ.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amb_cosim.controllers.laws import Law, balancing_factors
from array_types import Array, Bools, Indices

ALIKE = 1e3  # ratio of outputs of independent groups of states, below which both are equally observable


@dataclass(frozen=True)
class SlowModes:
    """Data of the slow modes for the model, in the coordinates of the law.

    tracking
        L, shape (n_states, n_demands).
    rest
        V_f (1 - A_f)^-1 W_f B: the steady states under a unit signal, with the slow modes at zero; shape (n_states,
        n_signals).
    slow
        V W, shape (n_states, n_states).
    """

    tracking: Array
    rest: Array
    slow: Array


def groups_of(pattern: Bools) -> list[Indices]:
    """Return mutually independent groups of states, found from the nonzero entries of A."""
    from scipy.sparse.csgraph import connected_components

    if not len(pattern):
        return []
    count, labels = connected_components(pattern, directed=False)
    return sorted((np.flatnonzero(labels == k) for k in range(count)), key=lambda group: int(group[0]))


def slow_modes(law: Law, sample_time: float, slow_time: float) -> SlowModes:
    """Return the slow modes of a sampled law.

    Parameters
    ----------
    law
        Law sampled at `sample_time` (s).
    slow_time
        Time constant (s) above which a mode is slow.

    Raises
    ------
    ValueError
        If slow and fast modes cannot be distinguished.
    """
    from scipy.linalg import block_diag

    n, (p, m) = len(law.A), law.D.shape
    alpha = math.exp(-sample_time / slow_time)
    rest, slow, bases, maps, parts = np.zeros((n, m)), np.zeros((n, n)), [], [], []
    for group in groups_of(law.A != 0.0):
        at = np.ix_(group, group)
        V, W, A_s, rest[group] = _split(law.A[at], law.B[group], alpha)
        slow[at] = V @ W
        basis = np.zeros((n, V.shape[1]))
        basis[group] = V
        bases.append(basis)
        parts.append(A_s)
        maps.append(law.C @ basis)
    tracking = np.zeros((n, p))
    n_slow = sum(len(part) for part in parts)
    if n_slow:
        scales = _scales(maps)
        bases, maps = ([scale * part for scale, part in zip(scales, of, strict=True)] for of in (bases, maps))
        tracking = np.hstack(bases) @ _gain(block_diag(*parts), np.hstack(maps), alpha)
    result = SlowModes(tracking, rest, slow)
    if not all(np.isfinite(value).all() for value in (tracking, rest, slow)):
        raise ValueError("the slow and fast modes of A cannot be separated; try another slow_time")
    return result


def _scales(maps: Sequence[Array]) -> list[float]:
    """Return a factor for each group, a power of two; the factors make the outputs of all slow modes similar in size.

    Groups whose outputs differ by a factor of less than `ALIKE` keep the factor 1.
    """
    sizes = [float(np.linalg.norm(of_group)) for of_group in maps]
    largest = max(sizes, default=0.0)
    small = [0.0 < size < largest / ALIKE for size in sizes]
    return [2.0 ** round(math.log2(largest / size)) if of else 1.0 for size, of in zip(sizes, small, strict=True)]


def _split(A: Array, B: Array, alpha: float) -> tuple[Array, Array, Array, Array]:
    """Return V, W and A_s of the slow modes, and the term `rest` of the fast modes."""
    from scipy.linalg import schur, solve_sylvester

    scale = balancing_factors(A)
    T, Z, n_slow = schur(A * scale[None, :] / scale[:, None], sort=lambda re, im=0.0: math.hypot(re, im) >= alpha)
    A_s, A_f = T[:n_slow, :n_slow], T[n_slow:, n_slow:]
    X = solve_sylvester(A_s, -A_f, -T[:n_slow, n_slow:]) if 0 < n_slow < len(T) else np.zeros((n_slow, len(A_f)))
    V, V_f = Z[:, :n_slow], Z[:, :n_slow] @ X + Z[:, n_slow:]
    W, W_f = Z[:, :n_slow].T - X @ Z[:, n_slow:].T, Z[:, n_slow:].T
    rest = V_f @ np.linalg.solve(np.eye(len(A_f)) - A_f, W_f @ (B / scale[:, None]))
    return V * scale[:, None], W / scale[None, :], A_s, rest * scale[:, None]


def _gain(A_s: Array, C_s: Array, alpha: float) -> Array:
    """Return W L of (1) and (2)."""
    from scipy.linalg import solve_discrete_lyapunov

    F_inverse = alpha * np.linalg.inv(A_s)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # for a mode at the limit X is very large, and its gain negligible
        X = solve_discrete_lyapunov(F_inverse.T, F_inverse.T @ C_s.T @ C_s @ F_inverse)
    to_demands = np.linalg.pinv((X + X.T) / 2.0, rcond=1e-12, hermitian=True) @ C_s.T
    return np.asarray(A_s @ to_demands @ np.linalg.inv(C_s @ to_demands + np.eye(len(C_s))))
