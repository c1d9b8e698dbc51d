"""Damped natural frequencies of a second-order rotor model."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigvals

from fmi_export.model import Array
from rotor_contact.assembly import Matrices


def eigenvalues(model: Matrices, Omega: float) -> Array:
    """All eigenvalues of M q'' + (C + Omega G) q' + K q = 0 at spin speed `Omega` (rad/s), complex, in rad/s."""
    n = model.size
    identity, zero = np.eye(n), np.zeros((n, n))
    A = np.block([[zero, identity], [-model.K, -(model.C + Omega * model.G)]])
    B = np.block([[identity, zero], [zero, model.M]])
    return np.asarray(eigvals(A, B))


def damped_frequencies(model: Matrices, Omega: float, count: int | None = None) -> Array:
    """Damped natural frequencies |Im lambda| > 0 in rad/s, ascending, one for each whirling mode.

    Parameters
    ----------
    model
        A model with bearings.
    Omega
        Spin speed (rad/s).
    count
        How many to return; all of them by default.
    """
    imaginary = eigenvalues(model, Omega).imag
    frequencies = np.sort(imaginary[imaginary > 1e-6])
    return frequencies[:count]
