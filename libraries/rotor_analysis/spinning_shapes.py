"""Shapes that the modes of the spinning rotor require in addition to a space of shapes of the rotor at rest.

With the M-orthonormal modes Phi of the free rotor at rest, W = diag(omega_k) and Gamma = Omega Phi^T G_1 Phi, circles
x + i y = Phi p exp(i omega t) of the rotor that spins at Omega obey

    (W^2 + omega Gamma - omega^2) p = 0                                                             (1)
    [[0, W], [W, Gamma]] [W p/omega; p] = omega [W p/omega; p].                                     (2)

The matrix of (2) is symmetric. A rotor with n elastic modes has n negative omega (backward whirl) and n + 1 positive
omega (forward whirl). The additional forward whirl is due to the gyroscopic moment of the tilting rotor. Three omega
are 0.

A space with the coordinates C = Phi^T M shapes lacks the part (1 - C C^T) p of a mode. The relative error of omega is
of second order:

    |e|^2,  e = W (1 - C C^T) p/omega  with |p| = 1.                                                (3)

The left singular vectors u of all e give the shapes Phi W^-1 u. The first of these shapes, with the largest singular
values, reduce the sum of (3) most.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.free_rotor import ResidualModes
from rotor_analysis.masters import SLOW, frequency_error
from rotor_analysis.modal_reduction import ShapeSpace

ROUNDING = 1e-7  # of |e|


def whirl(frequencies: Array, shapes: Array, G: Array) -> tuple[Array, Array]:
    """Return the frequencies of whirl (rad/s) in a space of shapes, and p of (1) in columns.

    The slowest forward whirl comes first. Backward and forward whirl then alternate, both in ascending order.

    Parameters
    ----------
    frequencies
        Frequencies of M-orthonormal shapes (rad/s), those of the rigid motions first, shape (m,).
    shapes
        The shapes in columns, shape (n, m).
    G
        Omega G_1 of a positive spin (N s/m), shape (n, n).
    """
    m, W = len(frequencies), np.diag(frequencies)
    omega, vectors = np.linalg.eigh(np.block([[np.zeros((m, m)), W], [W, shapes.T @ G @ shapes]]))
    order = np.zeros(2 * m - 3, dtype=int)
    order[::2], order[1::2] = np.arange(m + 1, 2 * m), np.arange(m - 3, -1, -1)
    return np.abs(omega[order]), vectors[m:, order]


def with_spinning_shapes(
    space: ShapeSpace, full: Matrices, speed: float, highest: float | None, accuracy: float
) -> ShapeSpace:
    """Return a space with few additional shapes that gives the spinning rotor the whirl frequencies of the full model.

    The additional shapes are combined with the residual shapes. A space that is accurate already is returned unchanged.

    Parameters
    ----------
    space
        Shapes of the rotor at rest.
    full
        The finite-element model of the free rotor.
    speed
        Spin speed (rad/s).
    highest
        Frequency (rad/s) up to which backward whirl must be accurate, together with the forward whirl of the same
        modes. With None, both must be accurate for each retained mode.
    accuracy
        Allowed relative error of the frequencies of whirl.

    Raises
    ------
    ValueError
        If rounding exceeds the accuracy.
    """
    rotor, M, G = space.rotor, full.M[::2, ::2], speed * full.G[::2, 1::2]
    frequencies, phi = np.concatenate([np.zeros(2), rotor.frequencies]), rotor.modes(len(rotor.frequencies))
    exact, p = whirl(frequencies, phi, G)
    modes = space.count if highest is None else int(np.count_nonzero(exact[1::2] <= highest))
    exact, p = exact[: 2 * modes + 1], p[:, : 2 * modes + 1]
    C, least = phi.T @ M @ space.shapes, np.inf
    lacking = (p - C @ (C.T @ p)) / np.linalg.norm(p, axis=0)
    u, size, _ = np.linalg.svd(frequencies[:, None] * lacking / np.maximum(exact, SLOW), full_matrices=False)
    flexible = frequencies > 0.0
    u[flexible] /= frequencies[flexible, None]
    for count in range(np.count_nonzero(size > ROUNDING) + 1):
        result = space
        if count:
            c = np.linalg.qr(np.hstack([C[:, 2 + space.count :], u[:, :count]]))[0]
            squares, turned = np.linalg.eigh(c.T @ (frequencies[:, None] ** 2 * c))
            result = replace(space, residual=ResidualModes(np.sqrt(squares), phi @ c @ turned))
        error = np.max(frequency_error(exact, whirl(result.frequencies, result.shapes, G)[0]))
        if error <= accuracy:
            return result
        least = min(error, least)
    what = f"whirl frequencies at reduction.speed = {speed:g} rad/s; the smallest error is {least:.1e}"
    raise ValueError(f"reduction.accuracy = {accuracy:g} is not reached for the {what}")
