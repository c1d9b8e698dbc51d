"""Critical speeds of a synchronous response, from its dynamic stiffness.

    D(Omega) q = Omega^2 (u, -i u),    D = H + i S with H and S Hermitian                         (1)

At a critical speed, an eigenvalue of H is zero. In its eigenvector v, inertia and stiffness then cancel, so only S
limits the motion, whatever the unbalance. Sorted by value, the eigenvalues of H are continuous functions of Omega, so
each change of sign between two speeds indicates a critical speed, even if several eigenvalues change sign at once. Near
a critical speed Omega_0, v* D v is lambda' (Omega - Omega_0) + i v* S v, and the half-width of the peak is

    sigma = |v* S v|/|lambda'|                                                                    (2)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from array_types import Array, Complex

CLOSE = 1e-9  # relative error of a critical speed


def resonances(stiffness: Callable[[float], Complex], speeds: Array) -> list[tuple[float, float]]:
    """Return the critical speeds between the first and the last of some speeds, and their half-widths (2).

    Parameters
    ----------
    stiffness
        Function that returns D of (1) at a speed.
    speeds
        Ascending (rad/s), shape (n,); between two neighbouring speeds, an eigenvalue may change its sign at most once.

    Returns
    -------
    list
        Critical speeds with their half-widths (rad/s), ascending.
    """

    @cache
    def eigenvalues(Omega: float) -> Array:
        D = stiffness(Omega)
        return np.asarray(np.linalg.eigvalsh(0.5 * (D + D.conj().T)), np.float64)

    result = []
    for low, high in pairwise(map(float, speeds)):
        for k in np.flatnonzero(eigenvalues(low) * eigenvalues(high) < 0.0):
            critical = float(brentq(lambda Omega, k=k: eigenvalues(Omega)[k], low, high, xtol=CLOSE * high))
            result.append((critical, _half_width(stiffness, critical, int(k), 1e-4 * (high - low))))
    return sorted(result)


def _half_width(stiffness: Callable[[float], Complex], Omega: float, k: int, step: float) -> float:
    """Return the half-width (rad/s) of the peak at the critical speed where eigenvalue k of H is zero."""
    D, D_next = stiffness(Omega), stiffness(Omega + step)
    _, shapes = np.linalg.eigh(0.5 * (D + D.conj().T))
    v = shapes[:, k]
    slope = ((v.conj() @ D_next @ v) - (v.conj() @ D @ v)).real / step
    return float(abs((v.conj() @ D @ v).imag) / abs(slope))
