"""Constants of the plant: matrices of the reduced rotor, stored in the FMU as one flat array."""

from __future__ import annotations

import numpy as np

from fmi_export.model import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.interface import N_BEARINGS, N_DISCS, N_SENSORS, N_SITES
from rotor_contact.structure import Structure


def plant_constants(rotor: Rotor | None = None) -> Array:
    """Return the flat constants of the plant: n, then the fields of `Structure` in order, row by row.

    The finite-element model of the free rotor is condensed to its master planes (`reduction.msdc`).

    Parameters
    ----------
    rotor
        A rotor description; the rig of the thesis by default.

    Raises
    ------
    ValueError
        If the numbers of discs, bearings, sensors and sites are not those of the plant, or the master planes do not
        hold the rotor.
    """
    rotor = rotor or load_rotor()
    for what, nodes, wanted in (
        ("bearings", rotor.bearing_nodes, N_BEARINGS),
        ("bodies with unbalance = true", rotor.disc_nodes, N_DISCS),
        ("sensors", rotor.sensor_nodes, N_SENSORS // 2),
        ("sites", rotor.site_nodes, N_SITES),
    ):
        if len(nodes) != wanted:
            raise ValueError(
                f"{what} = {list(nodes)} of rotor {rotor.name!r} is not allowed in a plant; it must be {wanted} nodes"
            )
    if not rotor.masters:
        raise ValueError(f"reduction.masters of rotor {rotor.name!r} is missing; a plant needs its master planes")
    full = assemble(rotor)
    reduction = msdc(full, rotor.masters)
    reduced = reduction.model
    if np.any(reduced.C):
        raise ValueError(f"shaft.mass_damping or stiffness_damping of rotor {rotor.name!r} is not 0, as in a plant")
    Minv: Array = np.linalg.inv(reduced.M).astype(np.float64)

    base_motion = np.zeros((full.size, 2))
    for rows in full.translations.values():
        base_motion[rows, (0, 1)] = 1.0

    def first_rows(nodes: tuple[int, ...]) -> Array:
        return np.array([reduced.translations[node][0] for node in nodes], dtype=np.float64)

    structure = Structure(
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
    )
    return np.concatenate([[float(reduced.size)], *(np.ravel(part) for part in structure)])
