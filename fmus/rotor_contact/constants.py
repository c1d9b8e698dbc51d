"""What the plant's kernels need of a rotor, computed once and stored in the FMU as one flat array."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from rotor_contact.assembly import assemble
from rotor_contact.interface import N_BEARINGS, N_DISCS, N_SENSORS, N_SITES
from rotor_contact.reduction import msdc
from rotor_contact.rotor import Rotor
from rotor_contact.rotor_file import load_rotor


class Structure(NamedTuple):
    """The reduced rotor, n degrees of freedom. A product with M^-1 is an acceleration.

    M, K
        Mass (kg) and stiffness (N/m), shape (n, n).
    Minv, MinvK, MinvG
        M^-1 and its products with K and with the gyroscopic matrix, shape (n, n).
    B_disc
        Forces on the masters for unit forces x, y on each disc, shape (n, 2 n_discs).
    B_base
        Forces on the masters for unit acceleration of the base in x, y, shape (n, 2); motion is relative to the base.
    sensors
        Sensor displacements from the masters, shape (n_sensors, n).
    bearings, sites
        Row of x of each magnetic bearing and of each contact site; y is the next.
    """

    M: Array
    K: Array
    Minv: Array
    MinvK: Array
    MinvG: Array
    B_disc: Array
    B_base: Array
    sensors: Array
    bearings: Array
    sites: Array


def plant_constants(rotor: Rotor | None = None) -> Array:
    """Flat constants of the plant: n, then the fields of `Structure` in order, row by row.

    The diagonal-mass finite-element model of the free rotor is condensed to its master planes (`reduction.msdc`).

    Parameters
    ----------
    rotor
        A rotor description; the rig of the thesis by default.

    Raises
    ------
    ValueError
        If the rotor does not have what the plant's interface shows, or its master planes cannot hold it.
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

    shaken = np.zeros((full.size, 2))
    for rows in full.translations.values():
        shaken[rows, (0, 1)] = 1.0

    def first_rows(nodes: tuple[int, ...]) -> Array:
        return np.array([reduced.translations[node][0] for node in nodes], dtype=np.float64)

    structure = Structure(
        M=reduced.M,
        K=reduced.K,
        Minv=Minv,
        MinvK=Minv @ reduced.K,
        MinvG=Minv @ reduced.G,
        B_disc=reduction.left[:, full.rows(planes.discs)],
        B_base=-reduction.left @ full.M @ shaken,
        sensors=reduction.right[full.rows(planes.sensors)],
        bearings=first_rows(rotor.bearing_nodes),
        sites=first_rows(planes.retainers),
    )
    return np.concatenate([[float(reduced.size)], *(np.ravel(part) for part in structure)])


@views
def structure_of(constants: Array) -> Structure:
    """Views into the flat constants."""
    n = int(constants[0])
    nn = n * n
    start = 1
    M = constants[start : start + nn].reshape(n, n)
    K = constants[start + nn : start + 2 * nn].reshape(n, n)
    Minv = constants[start + 2 * nn : start + 3 * nn].reshape(n, n)
    MinvK = constants[start + 3 * nn : start + 4 * nn].reshape(n, n)
    MinvG = constants[start + 4 * nn : start + 5 * nn].reshape(n, n)
    start += 5 * nn
    B_disc = constants[start : start + 2 * N_DISCS * n].reshape(n, 2 * N_DISCS)
    start += 2 * N_DISCS * n
    B_base = constants[start : start + 2 * n].reshape(n, 2)
    start += 2 * n
    sensors = constants[start : start + N_SENSORS * n].reshape(N_SENSORS, n)
    start += N_SENSORS * n
    bearings = constants[start : start + N_BEARINGS]
    sites = constants[start + N_BEARINGS : start + N_BEARINGS + N_SITES]
    return Structure(M, K, Minv, MinvK, MinvG, B_disc, B_base, sensors, bearings, sites)
