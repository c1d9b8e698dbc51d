"""Rotor data for the plant's kernels, computed once and stored in the FMU as one flat array."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.shaft.seals import N_SEAL, SEAL, Seals

REAL = np.dtype(np.float64)

# The constants begin with this record, and go on with the arrays of `Structure`, which explains the other fields.
SIZES = record(
    ("n", np.float64),  # degrees of freedom
    ("n_translations", np.float64),
    ("n_discs", np.float64),
    ("n_bearings", np.float64),
    ("n_sites", np.float64),
    ("n_sensors", np.float64),  # signals, two for each plane
    ("is_damped", np.float64),
    ("valid_to", np.float64),
    ("n_seals", np.float64),
    ("n_seal_ranges", np.float64),  # of speeds
    ("n_thrust", np.float64),
    ("mass", np.float64),
    ("n_faces", np.float64),
)
N_SIZES = size_of(SIZES)

# Where a face is: 1 if it pushes the rotor to larger z, -1 to smaller z; its height above the centre of mass (m); the
# number of the site on whose retainer it is, or -1.
FACE_PLACE = record(("side", np.float64), ("height", np.float64), ("site", np.float64))
N_FACE_PLACE = size_of(FACE_PLACE)
ROWS_OF_FACE = 8


class RowsOfFaces(NamedTuple):
    """The rows of all faces after their records in `Structure.faces`, shape (ROWS_OF_FACE n_faces, n)."""

    values: Array


class Structure(NamedTuple):
    """The reduced rotor with n degrees of freedom, which alternate between x and y.

    A product with M^-1 is an acceleration.
    """

    n_translations: int  # how many degrees of freedom are translations of planes; the rest are rotations or modes
    is_damped: bool  # whether C or R is not zero, or there are seals
    valid_to: float  # frequency (rad/s) up to which natural frequencies match the full model; infinite if unknown
    n_thrust: int  # discs of axial bearings, 0 or 1
    mass: float  # kg, with which the rotor moves along its shaft
    n_faces: int  # that limit the rotor's axial motion
    # Mass M (kg) and damping C and R (N s/m) of the shaft, stacked, shape (3 n, n). R rotates with the rotor: its force
    # is -R (v - Omega J q), where J q is q turned by a right angle in the direction of spin.
    forms: Array
    K: Array  # stiffness (N/m), shape (n, n)
    Minv: Array  # M^-1 and its products with K and with C + R, shape (n, n)
    MinvK: Array
    MinvC: Array
    over_speed: Array  # M^-1 G, with the gyroscopic matrix G, and M^-1 R J, stacked, (2 n, n); Omega multiplies both
    B_disc: Array  # forces due to unit forces in x and y on each disc, shape (2 n_discs, n)
    B_base: Array  # forces due to a unit acceleration of the base, to which the motion is relative, shape (2, n)
    sensors: Array  # sensor displacements from the degrees of freedom, shape (n_sensors, n)
    bearings: Array  # row of x of each magnetic bearing; the row of y is the next one
    sites: Array  # the same of each contact site
    site_bearings: Array  # for each site, the number of the bearing whose retainer it is, or -1 if there is none
    seals: Seals  # seals and passive bearings; their mass is in M
    # Records of type `FACE_PLACE`. Then, for each face, four rows give x, y and the slopes x', y' of the shaft from the
    # degrees of freedom. Four more rows, in the same order, contain the accelerations due to a unit force or moment on
    # each. Each row has n numbers.
    faces: Array


@views
def structure_of(constants: Array) -> Structure:
    """Return views into the flat constants."""
    sizes = part(constants, 0, SIZES, 1)[0]
    n, n_discs, n_bearings = int(sizes.n), int(sizes.n_discs), int(sizes.n_bearings)
    n_sites, n_sensors = int(sizes.n_sites), int(sizes.n_sensors)
    n_seals, n_seal_ranges = int(sizes.n_seals), int(sizes.n_seal_ranges)
    K = N_SIZES + 3 * n * n
    over_speed = K + 4 * n * n
    B_disc = over_speed + 2 * n * n
    sensors = B_disc + 2 * (n_discs + 1) * n
    bearings = sensors + n_sensors * n
    sites = bearings + n_bearings
    seals = sites + 2 * n_sites
    faces = seals + n_seal_ranges * n_seals * N_SEAL + 4 * n_seals * n
    return Structure(
        int(sizes.n_translations),
        sizes.is_damped != 0.0,
        sizes.valid_to,
        int(sizes.n_thrust),
        sizes.mass,
        int(sizes.n_faces),
        part(constants, N_SIZES, REAL, (3 * n, n)),
        part(constants, K, REAL, (n, n)),
        part(constants, K + n * n, REAL, (n, n)),
        part(constants, K + 2 * n * n, REAL, (n, n)),
        part(constants, K + 3 * n * n, REAL, (n, n)),
        part(constants, over_speed, REAL, (2 * n, n)),
        part(constants, B_disc, REAL, (2 * n_discs, n)),
        part(constants, sensors - 2 * n, REAL, (2, n)),
        part(constants, sensors, REAL, (n_sensors, n)),
        part(constants, bearings, REAL, n_bearings),
        part(constants, sites, REAL, n_sites),
        part(constants, sites + n_sites, REAL, n_sites),
        Seals(
            part(constants, seals, SEAL, (n_seal_ranges, n_seals)),
            part(constants, seals + n_seal_ranges * n_seals * N_SEAL, REAL, (4 * n_seals, n)),
        ),
        part(constants, faces, REAL, int(sizes.n_faces) * (N_FACE_PLACE + ROWS_OF_FACE * n)),
    )


@views
def rows_of_faces(structure: Structure) -> RowsOfFaces:
    """Return the rows of all faces."""
    n, n_faces = structure.K.shape[0], structure.n_faces
    return RowsOfFaces(part(structure.faces, n_faces * N_FACE_PLACE, REAL, (ROWS_OF_FACE * n_faces, n)))


@kernel
def row_of_face(port: int) -> int:
    """Return the row of x (or x') of a face; ports -1 and -2 are the place and slope of face 0, and so on."""
    number = -1 - port
    return ROWS_OF_FACE * (number // 2) + 2 * (number % 2)
