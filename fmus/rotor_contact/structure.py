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
    ("is_damped", np.float64),  # whether the shaft has damping: C or R is not zero
    ("valid_to", np.float64),  # see `Structure`
)
N_SIZES = size_of(SIZES)


class Structure(NamedTuple):
    """The reduced rotor, n degrees of freedom. A product with M^-1 is an acceleration.

    Degrees of freedom are x and y in turn: the first `n_translations` of planes, the rest of rotations or modes.

    valid_to
        Frequency (rad/s) up to which the natural frequencies are those of the full model; infinite if it is not known.
    forms
        Mass M (kg), damping C and R (N s/m) of the shaft, one below the other, shape (3 n, n). R turns with the rotor,
        J q being q turned by a right angle in the direction of spin: its force is -R (v - Omega J q).
    K
        Stiffness (N/m), shape (n, n).
    Minv, MinvK, MinvC
        M^-1 and its products with K and with C + R, shape (n, n).
    over_speed
        M^-1 G and M^-1 R J, G being the gyroscopic matrix, one below the other, shape (2 n, n); Omega multiplies both.
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
    is_damped: bool
    valid_to: float
    forms: Array
    K: Array
    Minv: Array
    MinvK: Array
    MinvC: Array
    over_speed: Array
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
    forms, rest = rest[: 3 * nn].reshape(3 * n, n), rest[3 * nn :]
    K, Minv, MinvK = rest[:nn].reshape(n, n), rest[nn : 2 * nn].reshape(n, n), rest[2 * nn : 3 * nn].reshape(n, n)
    MinvC, rest = rest[3 * nn : 4 * nn].reshape(n, n), rest[4 * nn :]
    over_speed, rest = rest[: 2 * nn].reshape(2 * n, n), rest[2 * nn :]
    B_disc, rest = rest[: 2 * n_discs * n].reshape(n, 2 * n_discs), rest[2 * n_discs * n :]
    B_base, rest = rest[: 2 * n].reshape(n, 2), rest[2 * n :]
    sensors, rest = rest[: n_sensors * n].reshape(n_sensors, n), rest[n_sensors * n :]
    bearings, rest = rest[:n_bearings], rest[n_bearings:]
    return Structure(
        int(sizes.n_translations),
        sizes.is_damped != 0.0,
        sizes.valid_to,
        forms,
        K,
        Minv,
        MinvK,
        MinvC,
        over_speed,
        B_disc,
        B_base,
        sensors,
        bearings,
        rest[:n_sites],
        rest[n_sites : 2 * n_sites],
    )
