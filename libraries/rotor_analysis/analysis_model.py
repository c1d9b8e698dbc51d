"""Model of a rotor on its bearings with as few coordinates as its lowest modes require, for analyses at many speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from array_types import Array, Complex
from rotor_analysis.assembly import Matrices, assemble, on_bearings
from rotor_analysis.free_rotor import FreeRotor, free_rotor
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.modal_reduction import ShapeSpace, reduce_to_shapes, space_with_residuals
from rotor_analysis.modes import modes
from rotor_analysis.reduction import reduce_by, unreduced
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.spectrum import eigenvalues, oscillating, slowest_eigenvalues
from rotor_analysis.spinning_shapes import with_spinning_shapes
from rotor_analysis.supported_rotor import SupportedRotor

ACCURACY = 1e-5  # of an eigenvalue
GROWTH = 1.25  # of the number of modes, until they are accurate


@dataclass(frozen=True)
class AnalysisModel:
    """A reduced rotor on its bearings.

    supported
        The rotor, its full model, and the reduced model for the analysis.
    error
        Largest relative error of the lowest modes' eigenvalues at the lowest and the highest speed; 0 if nothing was
        reduced.
    """

    supported: SupportedRotor
    error: float


def analysis_model(
    rotor: Rotor, mass: MassModel | None, speeds: Array, count: int, accuracy: float = ACCURACY
) -> AnalysisModel:
    """Try reductions of increasing size, and return the first whose lowest modes match those of the full model.

    max |lambda - lambda_full| / |lambda_full| <= accuracy, over `count` modes at both ends of `speeds`

    Each reduction retains a number of free modes, the residual shapes of bearings and seals, and the shapes that
    gyroscopic moments add at the highest speed (`spinning_shapes`). The number of free modes starts at half of `count`,
    because each of them vibrates in two planes and so provides two modes. If no reduction is accurate, or a node has no
    inertia, the full model is returned.

    Parameters
    ----------
    rotor
        Description of the rotor, including the stiffness and damping of its bearings.
    mass
        `consistent` or `diagonal`; by default as the rotor specifies.
    speeds
        Spin speeds (rad/s) of the analysis, shape (n,).
    count
        Number of modes, the lowest first.
    accuracy
        Allowed relative error of the eigenvalues of these modes; if it is 0, nothing is reduced.
    """
    free = assemble(rotor, mass)
    full = on_bearings(free, rotor)
    if not accuracy or lacks_inertia(free.M, free.K):
        return AnalysisModel(SupportedRotor(rotor, full, unreduced(full)), 0.0)
    nodes = tuple(sorted({*rotor.bearing_nodes, *rotor.seal_nodes} or {1, len(rotor.shaft.nodes)}))
    ends = [float(speed) for speed in (np.min(speeds), np.max(speeds))]
    exact = {speed: slowest_eigenvalues(full, speed, count) for speed in ends}
    free_modes, retained = free_rotor(free), -(-count // 2)
    while 4 * retained < full.size:
        space = _space(free_modes, free, retained, nodes, max(map(abs, ends)), accuracy)
        basis = reduce_to_shapes(free, space, nodes)
        reduction = reduce_by(full, basis.model.translations, basis.right, basis.left)
        error = 0.0
        for speed in ends:
            reduced = np.array([mode.eigenvalue for mode in modes(reduction.model, speed, count)])
            if np.abs(reduced).max(initial=0.0) > np.abs(exact[speed]).max():  # slow motion that is strongly damped
                exact[speed] = eigenvalues(full, speed)
            error = max(error, _error(reduced, exact[speed], count))
        if error <= accuracy:
            return AnalysisModel(SupportedRotor(rotor, full, reduction), error)
        retained = int(GROWTH * retained) + 1
    return AnalysisModel(SupportedRotor(rotor, full, unreduced(full)), 0.0)


def _space(
    rotor: FreeRotor, full: Matrices, count: int, nodes: tuple[int, ...], speed: float, accuracy: float
) -> ShapeSpace:
    """Return the span of the first elastic modes, all residual shapes of forces at nodes, and spinning shapes."""
    space = space_with_residuals(rotor, count, nodes)
    if not speed:
        return space
    try:
        return with_spinning_shapes(space, full, speed, None, accuracy)
    except ValueError:  # rounding exceeds the accuracy
        return space


def _error(reduced: Complex, exact: Complex, count: int) -> float:
    """Return the largest relative distance of a reduction's lowest modes from the nearest full-model eigenvalues.

    It is infinite if the reduction lacks some of these modes.
    """
    if len(reduced) < min(count, int(np.sum(oscillating(exact) & (exact.imag > 0.0)))):
        return np.inf
    return float(np.max(np.min(np.abs(reduced[:, None] - exact), axis=1) / np.abs(reduced), initial=0.0))
