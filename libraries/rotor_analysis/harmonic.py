"""Response of a spinning rotor at any of its nodes to harmonic forces f = Re[F exp(i omega t)] at any nodes.

    [-omega^2 M + i omega (C + Omega G) + K + D - L F(i omega) R] q = L f,   x = R q                  (1)
    f = (forces at the points, accelerations of the base),  L = (L_points, -L_nodes M 1)              (2)

M, C, G, K and D describe the rotor on all bearings that F does not contain. The rotor is reduced to its free modes up
to some frequency, and to the residual shapes of the nodes where forces act (`free_rotor`). R maps the coordinates to
the displacements of all nodes and of the centres of mass off their nodes; L maps forces at these points to the
coordinates. Displacements are relative to the base, so an acceleration of the base acts on all masses by (2), where 1
displaces the whole rotor. F(i omega) maps displacements to the forces of magnetic bearings and to other loads. A rotor
with a thrust disc also moves along its shaft as a free rigid mass. This motion is the last row of x, which only F
couples to the other rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from amb_files.checks import require
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices, assemble, with_bearings
from rotor_analysis.damping import free_modes
from rotor_analysis.modal_reduction import reduce_to_modes
from rotor_analysis.parts import Bearing, Point
from rotor_analysis.response import dynamic_stiffness
from rotor_analysis.rotor import Rotor

BEYOND = 3.0  # times the highest frequency: all modes up to there are retained
LEAST_MODES = 10  # for gyroscopic moments, which couple modes


@dataclass(frozen=True, eq=False)
class Forces:
    """The map F of (1) from displacements to loads, for some of the rows.

    rows, columns
        Rows of the loads f of (2) and of the displacements x (m); loads in the same row are added.
    at
        Function that takes frequencies (rad/s) of shape (n,) and returns F with the shape (n, rows, columns).
    """

    rows: Sequence[int]
    columns: Sequence[int]
    at: Callable[[Array | Complex], Complex]


@dataclass(frozen=True, eq=False)
class HarmonicModel:
    """A reduced rotor with its matrices in (1).

    model
        The rotor on its bearings, without the bearings whose forces F contains.
    right, left
        R and L of (1), with x and y of each point in turn, shapes (2 points, size) and (size, 2 points + 2). The points
        are all nodes, then the centres of mass that do not lie at their nodes, in the order of the bodies
        (`harmonic_points`). If the rotor has a thrust disc, its motion along the shaft is the row after the points and
        also the last coordinate. The last columns of L are the loads of a base that accelerates along x and y, and
        along the shaft if the rotor has a thrust disc.
    axial_mass
        Mass (kg) of a rotor with a thrust disc; 0 for a rotor without one.
    """

    model: Matrices
    right: Array
    left: Array
    axial_mass: float = 0.0

    @property
    def base_columns(self) -> slice:
        """Columns of L for accelerations of the base along x and y."""
        first = len(self.right)
        return slice(first, first + 2)

    def at(self, Omega: float) -> HarmonicModel:
        """Return the model at a spin speed (rad/s)."""
        return replace(self, model=self.model.at(Omega))

    def stiffness(self, omegas: Array | Complex, Omega: float, forces: Forces | None = None) -> Complex:
        """Return the matrix of (1) at frequencies and a spin speed (rad/s), shape (n, size, size).

        The product with F uses only the rows and columns of F, because including the rows and columns of all nodes
        would take most of the computing time of a response.
        """
        stiffness = dynamic_stiffness(self.model, Omega, omegas)
        if self.axial_mass:
            stiffness = np.pad(stiffness, ((0, 0), (0, 1), (0, 1)))
            stiffness[:, -1, -1] = -self.axial_mass * omegas**2
        if forces is not None:
            stiffness -= self.left[:, forces.rows] @ (forces.at(omegas) @ self.right[forces.columns])
        return stiffness

    def response(
        self, omegas: Array | Complex, Omega: float, inputs: Array | Complex, outputs: Array, forces: Forces | None
    ) -> Complex:
        """Return the outputs due to unit inputs, computed by (1), shape (n, outputs, inputs).

        Parameters
        ----------
        omegas
            Frequencies (rad/s), shape (n,); complex ones as for `dynamic_stiffness`.
        Omega
            Spin speed (rad/s).
        inputs
            Loads f of (2) due to unit inputs, shape (loads, inputs), or shape (n, loads, inputs) if they depend on the
            frequency; the accelerations of the base may be left out.
        outputs
            Outputs due to unit displacements, shape (outputs, 2 points).
        forces
            F of (1); none by default.

        Raises
        ------
        ValueError
            If a frequency equals the frequency of an undamped mode, or is not finite.
        """
        require(bool(np.isfinite(omegas).all()), "omega", "not finite", "finite")
        stiffness = self.stiffness(omegas, Omega, forces)
        try:
            motion = np.linalg.solve(
                stiffness,
                np.broadcast_to(
                    self.left[:, : inputs.shape[-2]] @ inputs, (len(omegas), len(self.left), inputs.shape[-1])
                ),
            )
        except np.linalg.LinAlgError as error:
            raise ValueError(
                "the response is unbounded: one frequency is the natural frequency of an undamped mode"
            ) from error
        return np.asarray((outputs @ self.right) @ motion)


def harmonic_model(rotor: Rotor, nodes: Iterable[int], highest: float, bearings: Iterable[Bearing]) -> HarmonicModel:
    """Return a model for the response of a rotor up to a frequency.

    Parameters
    ----------
    rotor
        Description of the rotor; its bearings and seals are ignored.
    nodes
        Nodes where forces act, including the nodes of magnetic bearings.
    highest
        Frequency (rad/s) up to which the response is accurate.
    bearings
        Bearings and seals on the rotor, without the bearings whose forces F contains.
    """
    supports = tuple(bearings)
    full = assemble(rotor)
    force_nodes = tuple({*nodes, *(bearing.node for bearing in supports)}) or (1, len(rotor.shaft.nodes))
    count = int(np.searchsorted(free_modes(full.M[::2, ::2], full.K[::2, ::2])[0], BEYOND * highest))
    reduction = reduce_to_modes(full, max(count, LEAST_MODES, len(force_nodes)), force_nodes)
    points = harmonic_points(rotor)
    right, left = full.at_points(reduction.right, points), full.at_points(reduction.left.T, points).T
    base = -reduction.left @ full.M @ full.base_motion
    model = with_bearings(reduction.model, supports)
    if not rotor.thrust:
        return HarmonicModel(model, right, np.hstack([left, base]))
    of_base = block_diag(base, -rotor.mass)
    return HarmonicModel(model, block_diag(right, 1.0), np.hstack([block_diag(left, 1.0), of_base]), rotor.mass)


def harmonic_points(rotor: Rotor) -> list[Point]:
    """Return the points of a `HarmonicModel`: all nodes, then the centres of mass off their nodes."""
    points = (rotor.point_of(body.name) for body in rotor.bodies)
    return [*range(1, len(rotor.shaft.nodes) + 1), *(point for point in points if not isinstance(point, int))]
