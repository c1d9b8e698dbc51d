"""What the plant's kernels need of a rotor, computed once and stored in the FMU as one flat array."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.assembly import assemble
from rotor_contact.interface import N_BEARINGS, N_DISCS, N_SENSORS
from rotor_contact.reduction import msdc
from rotor_contact.rotor import Rotor
from rotor_contact.rotor_file import load_rotor

N_RIG = 12  # degrees of freedom of the reduced rig; the plant's arrays have room for no more


class Structure(NamedTuple):
    """The reduced rotor, n degrees of freedom. A product with M^-1 is an acceleration.

    M, K
        Mass (kg) and stiffness (N/m), shape (n, n).
    Minv, MinvK, MinvG
        M^-1 and its products with K and with the gyroscopic matrix, shape (n, n).
    MinvB_disc
        Acceleration for unit forces x, y on each disc, shape (n, 2 n_discs).
    MinvB_base
        Acceleration for unit acceleration of the base in x, y, shape (n, 2); sign of the motion relative to it.
    sensors
        Sensor displacements from the masters, shape (n_sensors, n).
    rows
        Row of x of each bearing plane; y is the next. The retainer bearings sit in the same planes.
    """

    M: Array
    K: Array
    Minv: Array
    MinvK: Array
    MinvG: Array
    MinvB_disc: Array
    MinvB_base: Array
    sensors: Array
    rows: Array


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
        If the rotor's master planes cannot hold it, or are more than the plant has room for.
    """
    rotor = rotor or load_rotor()
    if 2 * len(rotor.planes.master) > N_RIG:
        raise ValueError(
            f"planes.master = {list(rotor.planes.master)} is not allowed; it must be at most {N_RIG // 2} node numbers"
        )
    full = assemble(rotor, "diagonal")
    reduction = msdc(full, rotor.planes.master)
    reduced = reduction.model
    Minv: Array = np.linalg.inv(reduced.M).astype(np.float64)

    shaken = np.zeros((full.size, 2))
    for rows in full.translations.values():
        shaken[rows, (0, 1)] = 1.0
    structure = Structure(
        M=reduced.M,
        K=reduced.K,
        Minv=Minv,
        MinvK=Minv @ reduced.K,
        MinvG=Minv @ reduced.G,
        MinvB_disc=Minv @ reduction.left[:, full.rows(rotor.planes.discs)],
        MinvB_base=-Minv @ reduction.left @ full.M @ shaken,
        sensors=reduction.right[full.rows(rotor.planes.sensors)],
        rows=np.array([reduced.translations[node][0] for node in rotor.bearing_nodes], dtype=np.float64),
    )
    return np.concatenate([[float(reduced.size)], *(np.ravel(part) for part in structure)])


@kernel
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
    MinvB_disc = constants[start : start + 2 * N_DISCS * n].reshape(n, 2 * N_DISCS)
    start += 2 * N_DISCS * n
    MinvB_base = constants[start : start + 2 * n].reshape(n, 2)
    start += 2 * n
    sensors = constants[start : start + N_SENSORS * n].reshape(N_SENSORS, n)
    start += N_SENSORS * n
    rows = constants[start : start + N_BEARINGS]
    return Structure(M, K, Minv, MinvK, MinvG, MinvB_disc, MinvB_base, sensors, rows)
