"""The free rotor at rest in one plane of motion, described by all its modes: shapes, receptance, residual shapes.

With a shift s > 0 that makes K + s M positive definite,

    (K + s M) S mu = M S,  S^T (K + s M) S = 1,  mu = 1/(omega^2 + s)                              (1)
    H(omega) = (K - omega^2 M)^-1 = -R R^T/omega^2 + sum S S^T/(1 - (s + omega^2) mu)              (2)

where R are the two rigid motions with R^T M R = 1. Massless rows have mu = 0 and add only stiffness to (2). A reduction
omits modes, but retains their static response to forces at some points p by means of residual attachment shapes (R. H.
MacNeal, Comput. Struct. 1, 1971; S. Rubin, AIAA J. 13, 1975; R. R. Craig, C.-J. Chang, 1977),

    A = sum S S_p^T/(1 - s mu) over these modes.                                                   (3)

The combinations A y with A^T M A y = nu A_p y are orthogonal to all retained modes and to each other. They are treated
as modes with omega^2 = 1/nu.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.inertia import inertial

SHIFT = 1e4  # rad^2/s^2
RESONANT = 1e-12  # least relative distance of omega^2 + s from that of a mode
MOVING = 1e-20  # share of the largest nu, below which a residual shape has no mass


@dataclass(frozen=True, eq=False)
class FreeRotor:
    """The modes of a free rotor in one plane of motion.

    nodes
        Row of the translation of each node, by node number.
    rigid
        Two rigid motions, translation and tilt about the centre of mass, with R^T M R = 1, shape (n, 2).
    mu
        1/(omega^2 + s) of the elastic modes (s^2/rad^2), descending, shape (n - 2,); the last ones are 0 for motions
        without mass.
    shapes
        S of (1), in the same order, shape (n, n - 2).
    """

    nodes: dict[int, int]
    rigid: Array
    mu: Array
    shapes: Array

    @property
    def frequencies(self) -> Array:
        """Natural frequencies of the elastic modes (rad/s), without motions that have no mass."""
        return np.sqrt(np.maximum(1.0 / self.mu[inertial(self.mu)] - SHIFT, 0.0))

    def modes(self, count: int) -> Array:
        """Return the shapes of the rigid motions and of the first `count` elastic modes, M-orthonormal, in columns."""
        return np.hstack([self.rigid, self.shapes[:, :count] / np.sqrt(self.mu[:count])])

    def rows(self, nodes: tuple[int, ...]) -> list[int]:
        """Return the rows of the translations at nodes."""
        return [self.nodes[node] for node in nodes]

    def receptance(self, rows: list[int], omega: ArrayLike, modes: slice = slice(None)) -> Array:
        """Return H of (2) between rows (m/N) at one or more frequencies (rad/s), from some or all elastic modes.

        With `omega` of shape S the result has the shape (*S, r, r).
        """
        s, square = self.shapes[rows, modes], np.square(omega)[..., None]
        distance = 1.0 - (SHIFT + square) * self.mu[modes]
        clear = np.copysign(np.maximum(np.abs(distance), RESONANT), distance)
        H: Array = (s / clear[..., None, :]) @ s.T
        return H if modes != slice(None) else H - self.rigid[rows] @ self.rigid[rows].T / square[..., None]

    def sizes(self, rows: list[int], omega: ArrayLike) -> Array:
        """Return the sum of the magnitudes of all terms of H_ii (2) for each row i (m/N); the sum has no antiresonance.

        With `omega` (rad/s) of shape S the result has the shape (*S, r).
        """
        square = np.square(omega)[..., None]
        distance = np.maximum(np.abs(1.0 - (SHIFT + square) * self.mu), RESONANT)
        elastic: Array = (1.0 / distance) @ (self.shapes[rows] ** 2).T
        return elastic + np.sum(self.rigid[rows] ** 2, axis=1) / square


@dataclass(frozen=True, eq=False)
class ResidualModes:
    """Residual attachment shapes (3) as modes, the slowest first: omega (rad/s) and M-orthonormal shapes in columns."""

    frequencies: Array
    shapes: Array


def free_rotor(full: Matrices) -> FreeRotor:
    """Return the modes of a free rotor from its finite-element model, which is the same in both planes of motion.

    The model's rows are x, y, x', y' of each node, as `assemble` returns them.
    """
    from scipy.linalg import eigh  # slow to import

    M, K = full.M[::2, ::2], full.K[::2, ::2]
    nodes = {node: rows[0] // 2 for node, rows in full.translations.items()}
    mu, shapes = eigh(M, K + SHIFT * M)
    rigid = _rigid_motions(M, shapes[:, -2:])
    return FreeRotor(nodes, rigid, np.maximum(mu[-3::-1], 0.0), np.asarray(shapes[:, -3::-1]))


def _rigid_motions(M: Array, shapes: Array) -> Array:
    """Return R, with R^T M R = 1, in the space spanned by two shapes."""
    L = np.linalg.cholesky(shapes.T @ M @ shapes)
    return np.asarray(np.linalg.solve(L, shapes.T).T)


def residual_modes(rotor: FreeRotor, count: int, nodes: tuple[int, ...], negligible: float) -> ResidualModes:
    """Return, as modes, the residual attachment shapes that forces at nodes add to the first `count` elastic modes.

    A combination of forces gets no shape if its residual flexibility is a negligible share of the whole elastic
    flexibility, because the frequency of such a shape would be high. An example is a pair of opposite forces at
    neighbouring nodes.
    """
    rows, elastic = rotor.rows(nodes), 1.0 - SHIFT * rotor.mu
    T = rotor.shapes / np.sqrt(elastic)  # T T^T is the elastic flexibility
    T_p = T[rows] / np.linalg.norm(T[rows], axis=1, keepdims=True)  # for forces that each have a flexibility of 1
    mu, T, T_p = rotor.mu[count:] / elastic[count:], T[:, count:], T_p[:, count:]
    size, directions = np.linalg.eigh(T_p @ T_p.T)
    flexible = size > negligible
    y = directions[:, flexible] / np.sqrt(size[flexible])  # unit strain energy
    nu, turned = np.linalg.eigh(y.T @ ((T_p * mu) @ T_p.T) @ y)
    nu, shapes = nu[::-1], T @ T_p.T @ y @ turned[:, ::-1]
    moving = nu > MOVING * np.max(nu, initial=0.0)
    return ResidualModes(1.0 / np.sqrt(nu[moving]), shapes[:, moving] / np.sqrt(nu[moving]))
