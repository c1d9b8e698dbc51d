"""The plant of a rotor: its variables, and the matrices of the reduced rotor in one flat array."""

from __future__ import annotations

import numpy as np

from fmi_export.model import Array, Model
from rotor_analysis.assembly import assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.planes import ContactSite, Planes, SensorPlane
from rotor_contact.plant import model_for
from rotor_contact.structure import SIZES, Structure


def plant(rotor: Rotor | None = None) -> tuple[Model, Array]:
    """Return the plant of a rotor, the rig of the thesis by default, and its constants; errors of `plant_constants`."""
    rotor = rotor or load_rotor()
    return model_for(planes_of(rotor)), plant_constants(rotor)


def planes_of(rotor: Rotor) -> Planes:
    """Return the planes for which the plant has variables, with their names in the rotor file."""
    sites = (
        ContactSite(
            s.name,
            s.clearance,
            _shaft_radius(rotor, s.node) if s.journal_radius is None else s.journal_radius,
            s.bearing or "",
        )
        for s in rotor.sites
    )
    return Planes(
        discs=tuple(body.name for body in rotor.discs),
        bearings=tuple(bearing.name for bearing in rotor.bearings),
        sites=tuple(sites),
        sensors=tuple(SensorPlane(s.name, s.x, s.y) for s in rotor.sensors),
    )


def _shaft_radius(rotor: Rotor, node: int) -> float:
    """Return the larger radius (m) of the shaft beside a node."""
    beside = [element.diameter[1] for element in rotor.elements[: node - 1][-1:]]
    beside += [element.diameter[0] for element in rotor.elements[node - 1 : node]]
    return max(beside) / 2.0


def plant_constants(rotor: Rotor | None = None) -> Array:
    """Return the flat constants of the plant: a record `SIZES`, then the arrays of `Structure` in order, row by row.

    The finite-element model of the free rotor is condensed to its master planes (`reduction.msdc`).

    Parameters
    ----------
    rotor
        A rotor description; the rig of the thesis by default.

    Raises
    ------
    ValueError
        If the rotor has no bearing, or the master planes do not hold it.
    """
    rotor = rotor or load_rotor()
    if not rotor.bearings:
        raise ValueError(f"rotor {rotor.name!r} has no bearings; a plant needs at least one")
    if not rotor.masters:
        raise ValueError(f"reduction.masters of rotor {rotor.name!r} is missing; a plant needs its master planes")
    full = assemble(rotor)
    reduction = msdc(full, rotor.masters)
    reduced = reduction.model
    Minv: Array = np.linalg.inv(reduced.M).astype(np.float64)

    base_motion = np.zeros((full.size, 2))
    for rows in full.translations.values():
        base_motion[rows, (0, 1)] = 1.0

    def first_rows(nodes: tuple[int, ...]) -> Array:
        return np.array([reduced.translations[node][0] for node in nodes], dtype=np.float64)

    number = {bearing.name: k for k, bearing in enumerate(rotor.bearings)}
    structure = Structure(
        n_translations=2 * len(reduced.translations),
        M=reduced.M,
        K=reduced.K,
        Minv=Minv,
        MinvK=Minv @ reduced.K,
        MinvG=Minv @ reduced.G,
        B_disc=reduction.left[:, full.rows(rotor.disc_nodes)],
        B_base=-reduction.left @ full.M @ base_motion,
        sensors=reduction.right[full.rows(rotor.sensor_nodes)],
        bearings=first_rows(rotor.bearing_nodes),
        sites=first_rows(rotor.site_nodes),
        site_bearings=np.array([number.get(site.bearing or "", -1) for site in rotor.sites], dtype=np.float64),
    )
    return flat_constants(structure)


def flat_constants(structure: Structure) -> Array:
    """Return a structure as `rotor_contact.structure.structure_of` reads it."""
    n_translations, *arrays = structure
    sizes = np.array(
        [
            (
                len(structure.M),
                n_translations,
                structure.B_disc.shape[1] // 2,
                len(structure.bearings),
                len(structure.sites),
                len(structure.sensors),
            )
        ],
        dtype=SIZES,
    )
    return np.concatenate([sizes.view(np.float64), *(np.ravel(part) for part in arrays)])
