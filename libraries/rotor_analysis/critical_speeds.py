"""Undamped critical speeds of a rotor on springs, and the antinodes of their mode shapes.

A synchronous forward whirl r exp(i Omega t) of the undamped rotor satisfies the following equation, in which G_1
contains the polar inertias in a single plane:

    (K + sum k_b e_b e_b^T) phi = Omega^2 (M - G_1) phi                                           (1)

K with the springs is positive definite, so (M - G_1) phi = mu K phi has real mu. Each mu > 0 gives a critical speed
Omega = 1/sqrt(mu). Because of the polar inertias of thick discs, not every mu is positive, so there are fewer critical
speeds than degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices


def critical_speeds(free: Matrices, springs: Mapping[int, float], count: int) -> tuple[Array, Array]:
    """Return the lowest undamped critical speeds and their mode shapes, computed by (1).

    Parameters
    ----------
    free
        The finite-element model of the free rotor, which is the same in both planes of motion.
    springs
        Stiffness (N/m) of the spring at each node, above 0; two nodes or more.
    count
        Number of critical speeds.

    Returns
    -------
    speeds, shapes
        Omega (rad/s), ascending, shape (n,), and phi at the translations of the nodes, scaled to a largest value of 1,
        shape (nodes, n).

    Raises
    ------
    ValueError
        If the springs do not support the rotor.
    """
    from scipy.linalg import eigh

    if len(springs) < 2 or min(springs.values()) <= 0.0:
        raise ValueError(f"springs = {dict(springs)} N/m are not allowed; there must be two or more, all > 0 N/m")
    M, K = free.M[::2, ::2], free.K[::2, ::2].copy()
    G_1 = free.G[::2, 1::2]  # G has G_1 times [[0, 1], [-1, 0]] over x and y
    row = {node: rows[0] // 2 for node, rows in free.translations.items()}
    for node, stiffness in springs.items():
        K[row[node], row[node]] += stiffness
    last = len(K) - 1
    mu, shapes = eigh(M - G_1, K, subset_by_index=(max(0, last + 1 - count), last))
    retained = mu[::-1] > 1e-16
    translations = shapes[[row[node] for node in sorted(row)]][:, ::-1][:, retained]
    largest = translations[np.abs(translations).argmax(axis=0), np.arange(translations.shape[1])]
    return 1.0 / np.sqrt(mu[::-1][retained]), translations / largest


def antinodes(shape: Array) -> list[tuple[int, slice]]:
    """Return, for each lobe of a shape between two zeros, the index of its maximum and the slice that it spans."""
    signs = _signs(shape)
    edges = [0, *(k + 1 for k in range(len(shape) - 1) if signs[k] * signs[k + 1] < 0.0), len(shape)]
    spans = [slice(a, b) for a, b in pairwise(edges)]
    return [(span.start + int(np.abs(shape[span]).argmax()), span) for span in spans]


def lobe_masses(free: Matrices, shape: Array) -> list[tuple[int, float, float]]:
    """Return, for each lobe of a shape, the index of its antinode (from 0), its modal mass (kg), and its sign.

    The modal mass is the mass of the rotor weighted by the shape:

        m_l = sum over the nodes of lobe l of m_k |phi_k|                                         (2)

    A mass near a zero of the shape hardly excites the mode, so it contributes little. The modal masses therefore depend
    neither on the mesh near a zero nor on the rounding that decides on which side of the zero a node lies.
    """
    translation = np.zeros(free.size)
    rows = [free.translations[node][0] for node in sorted(free.translations)]
    translation[rows] = 1.0
    weighted = (free.M @ translation)[rows] * np.abs(shape)
    return [(peak, float(weighted[span].sum()), float(np.sign(shape[peak]))) for peak, span in antinodes(shape)]


def _signs(shape: Array) -> Array:
    """Return the signs of a shape; a zero has the sign of the last nonzero value before it, or of the next one."""
    signs = np.sign(shape)
    nonzero = np.flatnonzero(signs)
    last = np.maximum(np.searchsorted(nonzero, np.arange(len(signs)), side="right") - 1, 0)
    return np.asarray(signs[nonzero[last]])
