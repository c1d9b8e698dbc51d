"""Referee: the magnetic field in a solid thrust bearing by finite volumes of the axially symmetric diffusion equation.

    -d/dr(1/(mu r) d psi/dr) - d/dz(1/(mu r) d psi/dz) + s sigma psi/r = J,      psi = r A_phi

The flux through a circle of radius r is 2 pi psi. J is the current density of the coil, which fills its slot; psi is 0
on the axis and far away. Cells are finest at all surfaces of the iron, where the field has its skin.
"""

from itertools import pairwise

import numpy as np
from scipy.constants import mu_0
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from thrust_bearings.disc import ThrustDisc
from thrust_bearings.eddy_currents import SolidIron

BACK, DISC, AROUND = 10e-3, 10e-3, 15e-3  # thickness of back iron and disc, air about both (m)


def gap_flux(disc: ThrustDisc, iron: SolidIron, s: complex, finest: float = 5e-5, growth: float = 1.25) -> complex:
    """Return the flux (Wb) of the inner pole in the middle of the gap under a current of 1 A."""
    (r_1, r_2), (r_3, r_4) = disc.poles
    faces = np.cumsum([0.0, AROUND, DISC, disc.gap, iron.slot_depth, BACK, AROUND])
    r = graded([0.0, r_1, r_2, r_3, r_4, r_4 + AROUND], finest, growth)
    z = graded(list(faces), finest, growth)
    r_mid, z_mid = 0.5 * (r[1:] + r[:-1]), 0.5 * (z[1:] + z[:-1])
    _, bottom, face, core, slot, back, _ = faces
    R, Z = np.meshgrid(r_mid, z_mid, indexing="ij")
    radial = (r_1 < R) & (r_4 > R)
    coil = (r_2 < R) & (r_3 > R) & (core < Z) & (slot > Z)
    solid = radial & (((bottom < Z) & (face > Z)) | ((core < Z) & (back > Z))) & ~coil
    nu = np.where(solid, 1.0 / (iron.permeability * mu_0), 1.0 / mu_0) / R
    sigma = np.where(solid, iron.conductivity, 0.0) / R
    J = np.where(coil, disc.turns / ((r_3 - r_2) * iron.slot_depth), 0.0)
    d_r, d_z = np.diff(r), np.diff(z)
    number = np.arange(len(r) * len(z)).reshape(len(r), len(z))
    # a quarter of each cell belongs to each of its corners, and half of its conductance to each of its edges
    rows, columns, values = [], [], []
    along_r, along_z = 0.5 * nu * d_z / d_r[:, None], 0.5 * nu * d_r[:, None] / d_z
    corners = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    for a, b, g in ((0, 1, along_r), (2, 3, along_r), (0, 2, along_z), (1, 3, along_z)):
        for i, k, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
            rows.append(corners[i].ravel())
            columns.append(corners[k].ravel())
            values.append((sign * g).ravel())
    quarter = 0.25 * d_r[:, None] * d_z
    right = np.zeros(number.size, dtype=complex)
    for of in corners:
        rows.append(of.ravel())
        columns.append(of.ravel())
        values.append((s * sigma * quarter).ravel())
        np.add.at(right, of.ravel(), (J * quarter).ravel())
    A = coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))).tocsc()
    inside = number[1:-1, 1:-1].ravel()
    psi = np.zeros(number.size, dtype=complex)
    psi[inside] = splu(A[inside][:, inside]).solve(right[inside])
    middle = int(np.abs(z - 0.5 * (face + core)).argmin())
    at = [int(np.abs(r - edge).argmin()) for edge in (r_1, r_2)]
    return complex(2.0 * np.pi * (psi[number[at[1], middle]] - psi[number[at[0], middle]]))


def graded(edges: list[float], finest: float, growth: float) -> np.ndarray:
    """Return coordinates that contain all edges, with steps that grow from both ends of each interval."""
    result = [np.array(edges[:1])]
    for a, b in pairwise(edges):
        half, step, marks = 0.5 * (b - a), finest, [0.0]
        while marks[-1] + step < half:
            marks.append(marks[-1] + step)
            step *= growth
        x = np.array([*marks[:-1], half] if len(marks) > 1 and half - marks[-1] < 0.5 * step else [*marks, half])
        result.append(np.concatenate([a + x[1:], b - x[:-1][::-1]]))
    return np.concatenate(result)
