"""Assembly of the rotor's matrices (`Matrices`), with four degrees of freedom per node: x, y, x' and y'."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from amb_files.checks import require_choice
from array_types import Array
from rotor_analysis import beam
from rotor_analysis.damping import damping_matrices
from rotor_analysis.element import Element
from rotor_analysis.hysteresis import Hysteresis
from rotor_analysis.pairs import MINUS_I, times_turned
from rotor_analysis.parts import Bearing, Point, seat
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import MASS_MODELS, MassModel


@dataclass(frozen=True, eq=False)
class AttachedBearing:
    """A bearing or seal attached to a model, at a point whose displacements need not be coordinates of the model.

    bearing
        The bearing, whose coefficients depend on the spin speed.
    right, left
        Maps from the coordinates to x and y of its position, shape (2, size), and from forces along x and y there to
        forces on the coordinates, shape (size, 2). For `Bearing.tilting` these are the maps of slopes and moments.
    """

    bearing: Bearing
    right: Array
    left: Array


@dataclass(frozen=True)
class Matrices:
    """Second-order model, M q'' + (C + R + Omega G) q' + (K - Omega R J) q = f, in SI units.

    Rows come in pairs, x and y of each plane; J turns each pair by a right angle, from x to y. Rotating damping resists
    motion relative to the shaft, with the force -R (q' - Omega J q).

    M, C, R, G, K
        Square arrays: mass (M), damping in the fixed frame (C) and in the frame of the shaft (R), gyroscopic matrix (G)
        and stiffness (K).
    translations
        Rows of x and y by node number (from 1).
    over_speed
        Bearings and seals whose coefficients depend on the spin speed; `at` adds these coefficients to M, K and C.
    hysteresis
        Additional hysteretic damping of the shaft, for motion at a single frequency; None if the shaft has none.
    slopes
        For a reduced model, the maps from the coordinates to the slopes x' and y' of each node in turn, shape (2 nodes,
        size), and from moments there to the coordinates. For the finite-element model this is None, because there the
        slopes of a node are the coordinates after its translations.
    """

    M: Array
    C: Array
    R: Array
    G: Array
    K: Array
    translations: dict[int, tuple[int, int]]
    over_speed: tuple[AttachedBearing, ...] = ()
    hysteresis: Hysteresis | None = None
    slopes: tuple[Array, Array] | None = None

    @property
    def size(self) -> int:
        return int(self.M.shape[0])

    def rows(self, nodes: tuple[int, ...]) -> list[int]:
        """Return the rows of the translations at `nodes`: x and y of the first, x and y of the next, ..."""
        return [row for node in nodes for row in self.translations[node]]

    def at_points(self, matrix: Array, points: Sequence[Point]) -> Array:
        """Return the rows of x and y at points, from a matrix with a row per coordinate of this finite-element model.

        At a centre of mass at distance d from its node, the displacement is x + d x'. The transpose maps a force there
        to its effect on the node: the force itself and a moment of d times the force.
        """
        rows = self.rows(tuple(seat(point) for point in points))
        offsets = np.repeat([0.0 if isinstance(point, int) else point.offset for point in points], 2)
        if not offsets.any():
            return np.asarray(matrix[rows])
        return np.asarray(matrix[rows] + offsets[:, None] * matrix[[row + 2 for row in rows]])

    @property
    def base_motion(self) -> Array:
        """Coordinates of this finite-element model due to unit displacements along x and y, shape (size, 2)."""
        result = np.zeros((self.size, 2))
        for rows in self.translations.values():
            result[rows, (0, 1)] = 1.0
        return result

    @property
    def translations_first(self) -> list[int]:
        """All rows, beginning with the rows of the translations."""
        first = [row for rows in self.translations.values() for row in rows]
        return first + [row for row in range(self.size) if row not in set(first)]

    def with_bearing(self, node: int, stiffness: Array, damping: Array, mass: Array | None = None) -> Matrices:
        """Add a bearing's 2 x 2 stiffness (N/m), damping (N s/m) and mass (kg) at `node`.

        Raises
        ------
        ValueError
            If the model has no translations at this node.
        """
        if node not in self.translations:
            raise ValueError(
                f"the model has no translations of node {node}; it has translations of nodes "
                f"{sorted(self.translations)}"
            )
        at = np.ix_(self.translations[node], self.translations[node])
        M, K, C = self.M.copy(), self.K.copy(), self.C.copy()
        K[at] += stiffness
        C[at] += damping
        M[at] += 0.0 if mass is None else mass
        return replace(self, M=M, C=C, K=K)

    def slopes_at(self, node: int) -> tuple[Array, Array]:
        """Return the maps from the coordinates to x' and y' of a node, and from moments at it to the coordinates."""
        if node not in self.translations and self.slopes is None:
            raise ValueError(
                f"the model has no slopes of node {node}; it has slopes of nodes {sorted(self.translations)}"
            )
        if self.slopes is None:
            selection = np.eye(self.size)[[row + 2 for row in self.translations[node]]]
            return selection, selection.T
        rows = slice(2 * (node - 1), 2 * node)
        return self.slopes[0][rows], self.slopes[1][:, rows]

    def with_moments(self, tilting: Bearing) -> Matrices:
        """Add `Bearing.tilting` at its node, with the terms left K_t right and left C_t right (see `slopes_at`)."""
        right, left = self.slopes_at(tilting.node)
        if tilting.at_speed:
            return replace(self, over_speed=(*self.over_speed, AttachedBearing(tilting, right, left)))
        K, C, _ = tilting.at(0.0)
        return replace(self, K=self.K + left @ K @ right, C=self.C + left @ C @ right)

    def at(self, Omega: float) -> Matrices:
        """Return the model at spin speed Omega (rad/s) as M q'' + (C + Omega G) q' + K q = f, without R.

        C and K include rotating viscous damping; M, C and K include all bearings and seals at this speed.
        """
        model = replace(self, over_speed=()) if self.over_speed else self
        if self.R.any():
            C, K = self.C + self.R, self.K - Omega * times_turned(self.R)
            model = replace(model, C=C, R=np.zeros_like(self.R), K=K)
        for attached in self.over_speed:
            K, C, M = (attached.left @ matrix @ attached.right for matrix in attached.bearing.at(Omega))
            model = replace(model, M=model.M + M, C=model.C + C, K=model.K + K)
        return model

    def viscous(self) -> Matrices:
        """Return this free rotor with viscous damping instead of hysteretic damping, for time-domain motion."""
        if self.hysteresis is None:
            return self
        C, R = self.hysteresis.viscous(self.M)
        return replace(self, C=self.C + C, R=self.R + R, hysteresis=None)


def assemble(rotor: Rotor, mass: MassModel | None = None) -> Matrices:
    """Assemble the free rotor, without its bearings (3.1 to 3.6).

    The centre of mass of a rigid body lies at a distance d (m) along +z from its node. If the node moves by x and tilts
    by the slope x' = dx/dz, then in both planes:

        x_c = x + d x',   T = m (dx_c/dt)^2/2 + I_d (dx'/dt)^2/2                                       (1)
        M = [[m, m d], [m d, I_d + m d^2]]   over (x, x')                                             (2)
        G = [[0, 0], [0, I_p]],   f = F [1, d]   for a force F at the centre of mass                   (3)

    m is the mass (kg); I_d and I_p are the diametral and polar moments of inertia (kg m^2) about the centre of mass.
    Spin adds only the term with I_p, because it turns the body about its axis without moving the centre of mass. The
    weight m g, the inertial force -m a due to base motion, and the unbalance force u Omega^2 act at the centre of mass.
    The weight, for example, loads the node with the moment m g d along x'.

    Parameters
    ----------
    rotor
        Description of the rotor.
    mass
        `consistent` (from the static deflection) or `diagonal` (half of each element at each of its end nodes); by
        default as the rotor specifies.

    Returns
    -------
    Matrices
        Size 4 n for n nodes; node k has rows 4 (k - 1) .. 4 (k - 1) + 3 for x, y, x', y'. C, R and hysteresis come only
        from the rotor's `damping`.

    Raises
    ------
    ValueError
        If `mass` is neither `consistent` nor `diagonal`.
    """
    mass = mass or rotor.shaft.mass_matrix
    require_choice("mass", mass, MASS_MODELS)
    nodes = rotor.shaft.nodes
    size = 2 * len(nodes)
    M, G, K = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    for e, layers in enumerate(rotor.elements):
        rows = slice(2 * e, 2 * e + 4)
        for layer in layers:
            for matrix, part in zip((M, G, K), element_matrices(layer, mass), strict=True):
                matrix[rows, rows] += part
    shaft_mass = M.copy()
    for body in rotor.bodies:
        w = 2 * (body.node - 1)
        M[w, w] += body.mass
        M[w, w + 1] += body.mass * body.offset
        M[w + 1, w] += body.mass * body.offset
        M[w + 1, w + 1] += body.diametral_inertia + body.mass * body.offset**2
        G[w + 1, w + 1] += body.polar_inertia
    damping, both_planes = rotor.damping, np.eye(2)
    C, R = damping_matrices(damping, shaft_mass, M, K)
    stiffness = np.kron(K, both_planes).astype(np.float64)
    hysteresis = Hysteresis(damping.loss_factor, damping.rotating, stiffness) if damping.loss_factor else None
    return Matrices(
        M=np.kron(M, both_planes).astype(np.float64),
        C=np.kron(C + 0.0, both_planes).astype(np.float64),  # no -0.0
        R=np.kron(R + 0.0, both_planes).astype(np.float64),
        G=np.kron(G, MINUS_I),
        K=stiffness,
        translations={k + 1: (4 * k, 4 * k + 1) for k in range(len(nodes))},
        hysteresis=hysteresis,
    )


def element_matrices(element: Element, mass: MassModel) -> tuple[Array, Array, Array]:
    """Return M, G_1 and K of an element in one plane, shape (4, 4) each (`beam`)."""
    if mass == "consistent":
        rotary = beam.consistent_rotary_inertia(element)
        return beam.consistent_translational_mass(element) + rotary, 2.0 * rotary, beam.stiffness(element)
    return *beam.diagonal_mass(element), beam.stiffness(element)


def on_bearings(model: Matrices, rotor: Rotor) -> Matrices:
    """Return `model` with the bearings and seals of `rotor`; `Matrices.at` adds the speed-dependent ones."""
    return with_bearings(model, (*rotor.bearings, *rotor.seals))


def with_bearings(model: Matrices, bearings: Iterable[Bearing]) -> Matrices:
    """Return the model with bearings added; it must have translations at the nodes of the bearings."""
    for bearing in bearings:
        if bearing.at_speed:
            selection = np.eye(model.size)[model.rows((bearing.node,))]
            model = replace(model, over_speed=(*model.over_speed, AttachedBearing(bearing, selection, selection.T)))
        else:
            model = model.with_bearing(bearing.node, *bearing.at(0.0))
        if bearing.tilting is not None:
            model = model.with_moments(bearing.tilting)
    return model
