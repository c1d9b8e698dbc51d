"""A rotor on its bearings, full or reduced, with forces and displacements at its nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amb_files.checks import require
from array_types import Array
from rotor_analysis.assembly import Matrices, assemble, on_bearings
from rotor_analysis.parts import Point, seat
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.reduction import Reduction, msdc, reduce_by, unreduced
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import MassModel


@dataclass(frozen=True)
class SupportedRotor:
    """The model of a rotor on its bearings.

    rotor
        Description of the rotor.
    full
        The finite-element model with the bearings.
    reduction
        The model for analyses: a reduction of `full`, or `full` itself with `right` = `left` = 1.
    """

    rotor: Rotor
    full: Matrices
    reduction: Reduction

    @property
    def model(self) -> Matrices:
        """The matrices for analyses."""
        return self.reduction.model

    @property
    def nodes(self) -> tuple[int, ...]:
        """All nodes of the rotor, including condensed ones."""
        return tuple(range(1, len(self.rotor.shaft.nodes) + 1))

    def displacement_of(self, points: Sequence[Point]) -> Array:
        """Return the matrix from the model's coordinates to x and y of points, shape (2 len(points), model.size)."""
        return self._at(self.reduction.right, points)

    def force_at(self, points: Sequence[Point]) -> Array:
        """Return the matrix from forces in x and y at points to the coordinates, shape (size, 2 len(points))."""
        return self._at(self.reduction.left.T, points).T

    @property
    def base_force(self) -> Array:
        """Forces on the coordinates due to unit accelerations of the base along x and y, -L M 1, shape (size, 2)."""
        return np.asarray(-self.reduction.left @ self.full.M @ self.full.base_motion)

    def _at(self, matrix: Array, points: Sequence[Point]) -> Array:
        for node in map(seat, points):
            require(node in self.full.translations, "node", node, f"a node number from 1 to {len(self.nodes)}")
        return self.full.at_points(matrix, points)


def supported_rotor(
    rotor: Rotor, mass: MassModel | None = None, planes: tuple[int, ...] | None = None
) -> SupportedRotor:
    """Return the model of `rotor` on its bearings (3.1 to 3.6), condensed to `planes` if given (MSDC, 3.8 to 3.13).

    Parameters
    ----------
    rotor
        Description of the rotor, with stiffness and damping of the bearings.
    mass
        `consistent` or `diagonal`; by default as the rotor specifies.
    planes
        Node numbers whose translations are retained; the full model by default.

    Raises
    ------
    ValueError
        If `mass` is neither `consistent` nor `diagonal`, if a plane does not exist, or if the rotor can still move
        freely when the planes are fixed.
    """
    full = on_bearings(assemble(rotor, mass), rotor)
    if planes is None:
        return SupportedRotor(rotor, full, unreduced(full))
    return SupportedRotor(rotor, full, msdc(full, planes))


def supported_plant(rotor: Rotor) -> SupportedRotor:
    """Return the model of `rotor` on its bearings in the coordinates of its plant (`reduced_rotor`).

    Raises
    ------
    ValueError
        As `reduced_rotor`.
    """
    full, plant = on_bearings(assemble(rotor), rotor), reduced_rotor(rotor)
    return SupportedRotor(rotor, full, reduce_by(full, plant.model.translations, plant.right, plant.left))
