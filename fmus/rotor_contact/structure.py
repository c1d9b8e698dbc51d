"""What the plant's kernels need of a rotor, computed once and stored in the FMU as one flat array."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.records import record, size_of

# The constants begin with this record, and go on with the arrays of `Structure`.
SIZES = record(
    ("n", np.float64),  # degrees of freedom
    ("n_translations", np.float64),  # of these; see `Structure`
    ("n_discs", np.float64),
    ("n_bearings", np.float64),
    ("n_sites", np.float64),
    ("n_sensors", np.float64),  # signals, two for each plane
)
N_SIZES = size_of(SIZES)


class Structure(NamedTuple):
    """The reduced rotor, n degrees of freedom. A product with M^-1 is an acceleration.

    The first `n_translations` degrees of freedom are x and y of planes in turn; the rest are rotations or modes.

    M, K
        Mass (kg) and stiffness (N/m), shape (n, n).
    Minv, MinvK, MinvG
        M^-1 and its products with K and with the gyroscopic matrix, shape (n, n).
    B_disc
        Forces on the degrees of freedom for unit forces x, y on each disc, shape (n, 2 n_discs).
    B_base
        Forces on them for unit acceleration of the base in x, y, shape (n, 2); motion is relative to the base.
    sensors
        Sensor displacements from the degrees of freedom, shape (n_sensors, n).
    bearings, sites
        Row of x of each magnetic bearing and of each contact site; y is the next.
    site_bearings
        Number of the bearing whose retainer a site is, or -1.
    """

    n_translations: int
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
    site_bearings: Array


@views
def structure_of(constants: Array) -> Structure:
    """Return views into the flat constants."""
    sizes, rest = constants[:N_SIZES].view(SIZES)[0], constants[N_SIZES:]
    n, n_discs, n_bearings = int(sizes.n), int(sizes.n_discs), int(sizes.n_bearings)
    n_sites, n_sensors = int(sizes.n_sites), int(sizes.n_sensors)
    nn = n * n
    M, K, Minv = rest[:nn].reshape(n, n), rest[nn : 2 * nn].reshape(n, n), rest[2 * nn : 3 * nn].reshape(n, n)
    MinvK, MinvG, rest = rest[3 * nn : 4 * nn].reshape(n, n), rest[4 * nn : 5 * nn].reshape(n, n), rest[5 * nn :]
    B_disc, rest = rest[: 2 * n_discs * n].reshape(n, 2 * n_discs), rest[2 * n_discs * n :]
    B_base, rest = rest[: 2 * n].reshape(n, 2), rest[2 * n :]
    sensors, rest = rest[: n_sensors * n].reshape(n_sensors, n), rest[n_sensors * n :]
    bearings, rest = rest[:n_bearings], rest[n_bearings:]
    return Structure(
        int(sizes.n_translations),
        M,
        K,
        Minv,
        MinvK,
        MinvG,
        B_disc,
        B_base,
        sensors,
        bearings,
        rest[:n_sites],
        rest[n_sites : 2 * n_sites],
    )
