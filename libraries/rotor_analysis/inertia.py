"""Modes of a model in which some coordinates have no inertia, such as those of a massless shaft.

    M phi = mu (K + s M) phi,   omega^2 = 1/mu - s                                                (1)

Motion without inertia has mu = 0. It follows the other coordinates statically, so it is not a mode. With s > 0 a motion
without stiffness has mu = 1/s, so that a rotor that cannot bend has finite mu, too.
"""

from __future__ import annotations

import numpy as np

from array_types import Array, Bools

MASSLESS = 1e-15  # mu over the largest mu: rounding of 0
SHIFT = 1e4  # rad^2/s^2, far below the squared frequencies of elements
DEPENDENT = 1e-13  # least eigenvalue of a mass matrix with diagonal 1: rounding of 0


def lacks_inertia(M: Array, K: Array) -> bool:
    """Return whether a model with mass M and stiffness K has a motion without inertia, within rounding error."""
    mu = np.diag(M) / np.diag(K + SHIFT * M)
    if np.min(mu, initial=np.inf) <= MASSLESS * np.max(mu, initial=0.0):
        return True
    scale = np.sqrt(np.diag(M))
    return bool(np.min(np.linalg.eigvalsh(M / np.outer(scale, scale)), initial=np.inf) <= DEPENDENT)


def inertial(mu: Array) -> Bools:
    """Return which mu of (1) belong to modes."""
    return np.asarray(mu > MASSLESS * np.max(mu, initial=0.0))


def inertias(M: Array, K: Array) -> int:
    """Return the number of independent motions that have inertia: the rank of M, scaled by the diagonal of K + s M."""
    scale = np.sqrt(np.diag(K + SHIFT * M))
    return int(np.count_nonzero(inertial(np.linalg.eigvalsh(M / np.outer(scale, scale)))))


def inertial_modes(M: Array, K: Array, shift: float = 0.0) -> tuple[Array, Array]:
    """Return the squared frequencies of all modes (rad^2/s^2), ascending, and phi in columns, with phi^T M phi = 1.

    Parameters
    ----------
    M, K
        Mass and stiffness, shape (n, n).
    shift
        s of (1) in rad^2/s^2, for which K + s M is positive definite.
    """
    from scipy.linalg import eigh  # slow to import

    mu, shapes = eigh(M, K + shift * M)
    has_inertia = inertial(mu)
    mu, shapes = mu[has_inertia][::-1], shapes[:, has_inertia][:, ::-1]
    return np.asarray(1.0 / mu - shift), np.asarray(shapes / np.sqrt(mu))
