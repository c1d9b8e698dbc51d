"""What the plant's kernels need of a rotor, computed once and stored in the FMU as one flat array."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.model import Array
from rotor_contact.interface import N_BEARINGS, N_DISCS, N_SENSORS, N_SITES


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


@views
def structure_of(constants: Array) -> Structure:
    """Return views into the flat constants."""
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
