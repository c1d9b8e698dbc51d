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

    The diagonal-mass finite-element model of the free rotor is condensed to its master planes (`reduction.msdc`).

    Parameters
    ----------
    rotor
        A rotor description; the rig of the thesis by default.

    Raises
    ------
    ValueError
        If the numbers of bearings and planes are not those of the plant, or the master planes do not hold the rotor.
    """
    rotor = rotor or load_rotor()
    planes = rotor.planes
    for what, nodes, wanted in (
        ("bearings", rotor.bearing_nodes, N_BEARINGS),
        ("planes.discs", planes.discs, N_DISCS),
        ("planes.sensors", planes.sensors, N_SENSORS // 2),
        ("planes.retainers", planes.retainers, N_SITES),
    ):
        if len(nodes) != wanted:
            raise ValueError(
                f"{what} = {list(nodes)} of rotor {rotor.name!r} is not allowed in a plant; it must be {wanted} nodes"
            )
    if not planes.master:
        raise ValueError(f"planes.master of rotor {rotor.name!r} is empty; a plant needs its master planes")
    full = assemble(rotor, "diagonal")
    reduction = msdc(full, planes.master)
    reduced = reduction.model
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
        B_disc=reduction.left[:, full.rows(planes.discs)],
        B_base=-reduction.left @ full.M @ base_motion,
        sensors=reduction.right[full.rows(planes.sensors)],
        bearings=first_rows(rotor.bearing_nodes),
        sites=first_rows(planes.retainers),
    )
    return np.concatenate([[float(reduced.size)], *(np.ravel(part) for part in structure)])
