"""The plant of a rotor: its variables, and the matrices of the reduced rotor in one flat array."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fmi_export.model import Array, Model
from rotor_analysis.assembly import Matrices, assemble, turned
from rotor_analysis.reduced_rotor import reduced_rotor, valid_to
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.planes import ContactSite, Planes, SensorPlane
from rotor_contact.plant import model_for
from rotor_contact.structure import SIZES, Structure

MAX_SUBSTEP = 250e-6  # s, of a rotor without fast modes
RESOLUTION = 1.0  # rad of the fastest mode in a substep
ROUNDING = 1e-9  # share of a site's displacement in that of another place that counts as none


def plant(rotor: Rotor | None = None) -> tuple[Model, Array]:
    """Return the plant of a rotor, by default that of the packs, and its constants.

    Raises
    ------
    ValueError
        If the rotor has no bearing, or cannot be reduced as its file says (`reduced_rotor`).
    """
    structure, planes = plant_structure(rotor or load_rotor())
    return model_for(planes), flat_constants(structure)


def plant_structure(rotor: Rotor) -> tuple[Structure, Planes]:
    """Return what the plant's kernels need of a rotor (`reduced_rotor`), and the planes with their names in its file.

    The start value of the longest substep makes it short enough for the fastest mode of the free rotor.

    Raises
    ------
    ValueError
        As `plant`.
    """
    if not rotor.bearings:
        raise ValueError(f"rotor {rotor.name!r} has no bearings; a plant needs at least one")
    if rotor.seals:
        names = ", ".join(seal.name for seal in rotor.seals)
        raise ValueError(f"rotor {rotor.name!r} has seals ({names}); the plant has none, the analyses have")
    full, reduction = assemble(rotor), reduced_rotor(rotor)
    reduced = reduction.model
    translations = [row for rows in reduced.translations.values() for row in rows]
    order = translations + [row for row in range(reduced.size) if row not in set(translations)]
    place = {row: k for k, row in enumerate(order)}
    at, left, right = np.ix_(order, order), reduction.left[order], reduction.right[:, order]
    M, C, R, K, G = (matrix[at] for matrix in (reduced.M, reduced.C, reduced.R, reduced.K, reduced.G))
    Minv: Array = np.linalg.inv(M).astype(np.float64)

    base_motion = np.zeros((full.size, 2))
    for rows in full.translations.values():
        base_motion[rows, (0, 1)] = 1.0

    def first_rows(nodes: tuple[int, ...]) -> Array:
        return np.array([place[reduced.translations[node][0]] for node in nodes], dtype=np.float64)

    number = {bearing.name: k for k, bearing in enumerate(rotor.bearings)}
    structure = Structure(
        n_translations=len(translations),
        is_damped=bool(np.any(C) or np.any(R)),
        valid_to=valid_to(full, reduced),
        forms=np.concatenate([M, C, R]),
        K=K,
        Minv=Minv,
        MinvK=Minv @ K,
        MinvC=Minv @ (C + R),
        over_speed=np.concatenate([Minv @ G, Minv @ R @ turned(reduced.size)]),
        B_disc=left[:, full.rows(rotor.disc_nodes)].T,
        B_base=-(left @ full.M @ base_motion).T,
        sensors=right[full.rows(rotor.sensor_nodes)],
        bearings=first_rows(rotor.bearing_nodes),
        sites=first_rows(rotor.site_nodes),
        site_bearings=np.array([number.get(site.bearing or "", -1) for site in rotor.sites], dtype=np.float64),
    )
    max_substep = float(min(MAX_SUBSTEP, RESOLUTION / _fastest(structure)))
    planes = _planes(rotor, max_substep, _polar_inertia(full), structure.valid_to)
    return structure, replace(planes, moved_by=_moved_by(planes, structure), mixes_axes=bool(np.any(R)))


def _moved_by(planes: Planes, structure: Structure) -> dict[str, tuple[str, ...]]:
    """Return the sites whose journal's displacement alone, the other coordinates zero, moves each place."""
    rows = dict(zip((site.name for site in planes.sites), structure.sites.astype(int), strict=True))
    unit = np.eye(len(structure.K))
    weights = {name: unit[row] for name, row in rows.items()}
    weights |= {name: unit[int(row)] for name, row in zip(planes.bearings, structure.bearings, strict=True)}
    weights |= {sensor.name: structure.sensors[2 * k] for k, sensor in enumerate(planes.sensors)}
    return {
        place: tuple(site for site, row in rows.items() if abs(weight[row]) > ROUNDING)
        for place, weight in weights.items()
    }


def _fastest(structure: Structure) -> float:
    """Return the largest eigenvalue (rad/s) of the free rotor at rest: of its fastest mode, or of one overdamped."""
    if not structure.is_damped:
        return float(np.sqrt(np.max(np.abs(np.linalg.eigvals(structure.MinvK)))))
    identity, zero = np.eye(len(structure.K)), np.zeros_like(structure.K)
    return float(np.max(np.abs(np.linalg.eigvals(np.block([[zero, identity], [-structure.MinvK, -structure.MinvC]])))))


def _polar_inertia(full: Matrices) -> float:
    """Return the polar inertia (kg m^2) of a rotor: what couples its tilting as a rigid body in both planes."""
    tilt = np.zeros((2, full.size))
    for rows in full.translations.values():
        for axis in range(2):
            tilt[axis, rows[axis] + 2] = 1.0
    return float(tilt[0] @ full.G @ tilt[1])


def _planes(rotor: Rotor, max_substep: float, polar_inertia: float, valid_to: float) -> Planes:
    sensors = {sensor.node: sensor.name for sensor in reversed(rotor.sensors)}
    sites = (
        ContactSite(
            s.name,
            s.clearance,
            _shaft_radius(rotor, s.node) if s.journal_radius is None else s.journal_radius,
            s.bearing or "",
            sensors.get(s.node, ""),
        )
        for s in rotor.sites
    )
    return Planes(
        discs=tuple(body.name for body in rotor.discs),
        bearings=tuple(bearing.name for bearing in rotor.bearings),
        sites=tuple(sites),
        sensors=tuple(SensorPlane(s.name, s.x, s.y) for s in rotor.sensors),
        max_substep=max_substep,
        polar_inertia=polar_inertia,
        valid_to=valid_to,
    )


def _shaft_radius(rotor: Rotor, node: int) -> float:
    """Return the larger radius (m) of the shaft beside a node."""
    before, after = rotor.elements[: node - 1][-1:], rotor.elements[node - 1 : node]
    beside = [layer.diameter[1] for layers in before for layer in layers]
    beside += [layer.diameter[0] for layers in after for layer in layers]
    return max(beside) / 2.0


def flat_constants(structure: Structure) -> Array:
    """Return a structure as `rotor_contact.structure.structure_of` reads it."""
    n_translations, is_damped, valid_to, *arrays = structure
    sizes = np.array(
        [
            (
                len(structure.K),
                n_translations,
                len(structure.B_disc) // 2,
                len(structure.bearings),
                len(structure.sites),
                len(structure.sensors),
                is_damped,
                valid_to,
            )
        ],
        dtype=SIZES,
    )
    return np.concatenate([sizes.view(np.float64), *(np.ravel(part) for part in arrays)])
