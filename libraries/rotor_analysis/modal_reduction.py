"""Reduction to free modes of the whole rotor and residual attachment shapes of bearings and sites (`free_rotor`).

In each plane of motion, the displacement of the rotor is a combination of m M-orthonormal shapes Phi with frequencies
omega. The plant requires the displacements x_p of a few points p (contact sites and bearings) as coordinates. The other
coordinates are motions in which these points are at rest. With an orthonormal basis N of the null space of Phi_p,

    q = Phi eta,  eta = Phi_p^+ x_p + N xi,   N^T diag(omega^2) N diagonal                          (1)
    M = [[(Phi_p Phi_p^T)^-1, 0], [0, 1]],  K = Y^T diag(omega^2) Y,  Y = [Phi_p^+, N]             (2)

This is a change of coordinates within the same space. The displacement of any other point is given by a row of Phi Y
and requires no coordinate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.free_rotor import FreeRotor, ResidualModes, free_rotor, residual_modes
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.reduction import Reduction, reduce_by, unreduced

LEAST_INDEPENDENCE = 1e-6  # of places: smallest over largest singular value of Phi_p, its rows scaled to 1
ROUNDING = 1e-10  # share of the elastic flexibility
N_FREQUENCIES = 100  # in a band, at which the receptance is compared


@dataclass(frozen=True, eq=False)
class ShapeSpace:
    """Shapes to which a rotor is reduced in a plane of motion.

    rotor
        The free rotor.
    count
        Number of retained elastic modes, in addition to both rigid motions.
    residual
        Retained residual shapes, and additional shapes of the spinning rotor (`spinning_shapes`).
    """

    rotor: FreeRotor
    count: int
    residual: ResidualModes

    @property
    def shapes(self) -> Array:
        """Phi, M-orthonormal, in columns."""
        return np.hstack([self.rotor.modes(self.count), self.residual.shapes])

    @property
    def frequencies(self) -> Array:
        """Frequencies of the shapes (rad/s)."""
        return np.concatenate([np.zeros(2), self.rotor.frequencies[: self.count], self.residual.frequencies])

    def receptance_error(self, nodes: tuple[int, ...], omega: ArrayLike) -> float:
        """Return the largest error of the receptance between nodes against the full model, at some frequencies (rad/s).

        |H_ij reduced - H_ij| / sqrt(S_i S_j), with S_i the sum of magnitudes of all modal terms of H_ii (m/N).
        """
        rows = self.rotor.rows(nodes)
        psi = self.residual.shapes[rows]
        restored = (psi / (self.residual.frequencies**2 - np.square(omega)[..., None])[..., None, :]) @ psi.T
        error = np.abs(restored - self.rotor.receptance(rows, omega, slice(self.count, None)))
        size = np.sqrt(self.rotor.sizes(rows, omega))
        return float(np.max(error / (size[..., :, None] * size[..., None, :])))

    def largest_error(self, nodes: tuple[int, ...], highest: float) -> float:
        """Return the largest `receptance_error` up to a frequency (rad/s)."""
        return self.receptance_error(nodes, np.linspace(0.0, highest, N_FREQUENCIES + 1)[1:])


def space_with_modes(rotor: FreeRotor, count: int, nodes: tuple[int, ...], accuracy: float) -> ShapeSpace:
    """Return the space of `count` elastic modes and the residual shapes of forces at `nodes`.

    A residual shape is left out if omitting it changes no static elastic displacement by more than `accuracy`.

    Raises
    ------
    ValueError
        If the rotor does not have that many modes.
    """
    most = len(rotor.frequencies)
    if not 0 <= count <= most:
        raise ValueError(
            f"reduction.modes = {count} is not allowed; it must be from 0 to {most}, the number of elastic modes of "
            "the free rotor"
        )
    return ShapeSpace(rotor, count, residual_modes(rotor, count, nodes, 2.0 * accuracy))


def space_with_residuals(rotor: FreeRotor, count: int, nodes: tuple[int, ...]) -> ShapeSpace:
    """Return the space of the first elastic modes, at most `count`, and all residual shapes of forces at nodes."""
    count = min(count, len(rotor.frequencies))
    return ShapeSpace(rotor, count, residual_modes(rotor, count, nodes, ROUNDING))


def space_for_band(rotor: FreeRotor, highest: float, nodes: tuple[int, ...], accuracy: float) -> ShapeSpace:
    """Return the smallest space with an accurate receptance between nodes; of several such spaces, the least stiff one.

    Parameters
    ----------
    rotor
        The free rotor.
    highest
        Frequency (rad/s) up to which the receptance must be accurate.
    nodes
        Nodes at which forces act. Their displacements must be independent in the space.
    accuracy
        Allowed error (`ShapeSpace.receptance_error`).

    Raises
    ------
    ValueError
        If even all modes together do not reach the accuracy.
    """
    most, best, least = len(rotor.frequencies), np.inf, np.inf
    smallest: list[ShapeSpace] = []
    for count in range(max(int(np.searchsorted(rotor.frequencies, highest)) - len(nodes), 0), most + 1):
        if 2 + count > best:
            break
        for space in _spaces(rotor, count, nodes):
            size = len(space.frequencies)
            if size > best or _independence(space, nodes) < LEAST_INDEPENDENCE:
                continue
            error = space.largest_error(nodes, highest)
            least = min(error, least)
            if error <= accuracy:
                smallest = [*smallest, space] if size == best else [space]
                best = size
                break
    if not smallest:
        raise ValueError(f"reduction.accuracy = {accuracy:g} is not reached: the smallest error is {least:.1e}")
    return min(smallest, key=lambda space: float(np.max(space.frequencies)))


def _spaces(rotor: FreeRotor, count: int, nodes: tuple[int, ...]) -> Iterator[ShapeSpace]:
    """Yield the spaces of `count` elastic modes with none, one, ... of the residual shapes of forces at `nodes`."""
    residual = residual_modes(rotor, count, nodes, ROUNDING)
    for retained in range(len(residual.frequencies) + 1):
        yield ShapeSpace(rotor, count, ResidualModes(residual.frequencies[:retained], residual.shapes[:, :retained]))


def _independence(space: ShapeSpace, places: tuple[int, ...]) -> float:
    """Return the ratio of the smallest to the largest singular value of Phi_p with its rows scaled to norm 1.

    The ratio is 0 if Phi_p has more rows than columns.
    """
    at = space.shapes[space.rotor.rows(places)]
    if len(at) > at.shape[1]:
        return 0.0
    values = np.linalg.svd(at / np.linalg.norm(at, axis=1, keepdims=True), compute_uv=False)
    return float(values[-1] / values[0])


def reduce_to_shapes(full: Matrices, space: ShapeSpace, places: tuple[int, ...]) -> Reduction:
    """Reduce a free rotor to a space of shapes, with the displacements of some points among its coordinates.

    Parameters
    ----------
    full
        The finite-element model of the free rotor.
    space
        The shapes.
    places
        Numbers of the nodes whose translations come first.

    Raises
    ------
    ValueError
        If the shapes do not distinguish the points.
    """
    if _independence(space, places) < LEAST_INDEPENDENCE:
        what = f"the {len(space.frequencies)} shapes in a plane of motion cannot distinguish these places"
        raise ValueError(
            f"places at nodes {list(places)} are not allowed; {what}: retain more modes, or merge the places"
        )
    phi, squares = space.shapes, space.frequencies**2
    at = phi[space.rotor.rows(places)]
    to_places = np.linalg.pinv(at)
    resting = np.linalg.svd(at)[2][len(places) :].T
    resting = resting @ np.linalg.eigh(resting.T @ (squares[:, None] * resting))[1]
    Y = np.hstack([to_places, resting])
    M = np.eye(len(squares))
    M[: len(places), : len(places)] = np.linalg.inv(at @ at.T)
    K = Y.T @ (squares[:, None] * Y)
    both = np.eye(2)
    right = np.kron(phi @ Y, both)
    translations = {node: (2 * i, 2 * i + 1) for i, node in enumerate(places)}
    reduction = reduce_by(full, translations, right, right.T)
    M, K = (np.kron(0.5 * (matrix + matrix.T), both) for matrix in (M, K))
    return replace(reduction, model=replace(reduction.model, M=M, K=K))


def reduce_to_modes(full: Matrices, count: int, nodes: tuple[int, ...]) -> Reduction:
    """Reduce a free rotor to its first elastic modes, at most `count`, and all residual shapes of forces at nodes.

    The translations at these nodes come first. If a node has no inertia, the rotor is not reduced.

    Raises
    ------
    ValueError
        As `reduce_to_shapes`.
    """
    if lacks_inertia(full.M, full.K):
        return unreduced(full)
    places = tuple(sorted({*nodes}))
    return reduce_to_shapes(full, space_with_residuals(free_rotor(full), count, places), places)
