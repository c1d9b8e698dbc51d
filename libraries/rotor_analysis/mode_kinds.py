"""Kinds of mode shapes, which depend on the share of rigid-body motion and on how often the shaft crosses the axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from array_types import Array, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.modes import translations

RIGID = 0.5  # share of the kinetic energy from which on a mode is a rigid-body mode
SIGN_THRESHOLD = 1e-3  # of the largest displacement; smaller ones have no sign


class ModeKind(NamedTuple):
    """Kind of a mode shape.

    name
        `conical` for rigid-body motion whose line crosses the axis between the ends, `cylindrical` for other
        rigid-body motion, `flexural` for bending.
    rigid_share
        Share of the kinetic energy in the rigid-body motion nearest to the mode (1).
    crossings
        Number of points between the ends at which the shaft line crosses the axis.
    """

    name: str
    rigid_share: float
    crossings: int


def kind_of(model: Matrices, z: Array, shape: Complex) -> ModeKind:
    """Return the kind of a mode shape of a finite-element model.

    share = p^H M p/(phi^H M phi),  p = B (B^T M B)^-1 B^T M phi, with B two translations and two rotations

    Parameters
    ----------
    model
        Matrices with displacements and slopes of all nodes.
    z
        Axial position of the nodes (m), shape (nodes,).
    shape
        The mode shape, shape (4 nodes,).
    """
    rigid = np.zeros((model.size, 4))
    for plane in (0, 1):
        rigid[plane::4, plane] = 1.0
        rigid[plane::4, 2 + plane] = z
        rigid[2 + plane :: 4, 2 + plane] = 1.0
    nearest = rigid @ np.linalg.solve(rigid.T @ model.M @ rigid, rigid.T @ model.M @ shape)
    share = float((nearest.conj() @ model.M @ nearest).real / (shape.conj() @ model.M @ shape).real)
    crossings = _crossings(translations(model, shape))
    if share < RIGID:
        return ModeKind("flexural", share, crossings)
    return ModeKind("conical" if _crossings(translations(model, nearest)) else "cylindrical", share, crossings)


def _crossings(displacement: Complex) -> int:
    """Return how often the shaft line crosses the axis, seen in the plane and at the instant of its largest motion.

    Parameters
    ----------
    displacement
        x and y of each node, shape (nodes, 2), complex.
    """
    node, plane = np.unravel_index(np.argmax(np.abs(displacement)), displacement.shape)
    line = (displacement[:, plane] / displacement[node, plane]).real
    return int(np.count_nonzero(np.diff(np.sign(line[np.abs(line) > SIGN_THRESHOLD]))))
