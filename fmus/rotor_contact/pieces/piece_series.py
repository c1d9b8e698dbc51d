"""The motion in a solved piece as a Taylor series, used where a piece is cut and between the Lobatto points.

With s = t/h in a piece of length h, y(s) = sum_k y_k s^k for y = (q, v), and

    q_(k+1) = h/(k+1) v_k,    v_(k+1) = h/(k+1) (f_k - K q_k - C v_k)            (1)

f_k are the coefficients of the accelerations due to all forces: steady ones (k = 0), the unbalance
(A + i B) (i Omega h)^k/k!, and the cubics through the node forces. No equations have to be solved again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.contact.path import Point
from rotor_contact.contact.site import Site, race_radius
from rotor_contact.contact.workspace import Workspace
from rotor_contact.forces.dynamics import accelerations
from rotor_contact.matrices.matrix_sizes import MAX_TERMS, series_size
from rotor_contact.matrices.speed_grid import BLENDS, grid_speed, slot_of
from rotor_contact.matrices.step_matrices import StepMatrices, coefficients_at
from rotor_contact.pieces.piece import Piece, piece_of
from rotor_contact.shaft.lobatto import LAGRANGE, N_LOBATTO, value_at
from rotor_contact.shaft.products import interpolate, row_combination
from rotor_contact.shaft.structure import REAL

LEAST_TERM = 1e-11  # of the largest velocity so far: a smaller term ends the series


class PieceSeries(NamedTuple):
    """Terms y_k, shape (MAX_TERMS, 2 N), and room for a state and for accelerations, shape (2 N,) each."""

    terms: Array
    y: Array
    a: Array


@views
def series_of(matrices: StepMatrices) -> PieceSeries:
    """Return the series of a piece."""
    n = int(matrices.sizes[0].n)
    at = matrices.pieces.shape[0] - series_size(n)
    return PieceSeries(
        part(matrices.pieces, at, REAL, (MAX_TERMS, 2 * n)),
        part(matrices.pieces, at + MAX_TERMS * 2 * n, REAL, 2 * n),
        part(matrices.pieces, at + (MAX_TERMS + 1) * 2 * n, REAL, 2 * n),
    )


@noinline_kernel
def expand(w: Workspace, matrices: StepMatrices, index: float, h: float, reach: float) -> int:
    """Write the terms (1) of a piece of length h (s) with a complete x; return their number.

    The number is 0 if `MAX_TERMS` terms do not suffice. The series is for shares s up to `reach`; `index` is the
    position of the speed on the grid.
    """
    piece, series, n = piece_of(matrices), series_of(matrices), int(matrices.sizes[0].n)
    terms, a = series.terms, series.a[:n]
    slot = _coefficients(matrices, index)
    KC, turn = coefficients_at(matrices, slot).columns, complex(0.0, grid_speed(matrices, index) * h)
    direction = complex(piece.x[2 * n + 2], piece.x[2 * n + 3])
    copy(piece.x[: 2 * n], terms[0])
    fastest, power = 0.0, 1.0
    for k in range(MAX_TERMS - 1):
        y, following, dt = terms[k], terms[k + 1], h / (k + 1)
        row_combination(y, KC, a, n)
        for i in range(n):
            a[i] = -a[i]
        _add_forces(w, matrices, piece, k, direction, a)
        direction *= turn / (k + 1)
        largest, power = 0.0, power * reach
        for i in range(n):
            following[i], following[n + i] = dt * y[n + i], dt * a[i]
            fastest = max(fastest, abs(y[n + i]))
            largest = max(largest, max(abs(following[n + i]), abs(following[i]) / h))
        if k >= N_LOBATTO and power * largest <= LEAST_TERM * fastest:
            return k + 2
    return 0


@kernel
def _coefficients(matrices: StepMatrices, index: float) -> int:
    """Return the slot with K and C at a point of the grid; between two grid speeds, K and C are interpolated."""
    low = float(math.floor(index))
    if index == low:
        return slot_of(low)
    below = coefficients_at(matrices, slot_of(low)).columns
    above = coefficients_at(matrices, slot_of(low + 1.0)).columns
    between = coefficients_at(matrices, BLENDS).columns
    for i in range(below.shape[0]):
        interpolate(below[i], above[i], index - low, between[i], below.shape[1])
    return BLENDS


@kernel
def _add_forces(w: Workspace, matrices: StepMatrices, piece: Piece, k: int, direction: complex, a: Array) -> None:
    """Add the accelerations due to term k of all forces; `direction` is the direction of the unbalance."""
    m, first = w.Minv.shape[0], piece.x.shape[0] - piece.magnets.shape[0]
    caused, axes = accelerations(w.motion), piece.magnets.shape[0] // N_LOBATTO
    for i in range(m):
        a[i] += direction.real * caused.cosine[i] + direction.imag * caused.sine[i]
    if k == 0:
        for i in range(m):
            a[i] += caused.without_magnets[i]
        for site in w.sites:
            if site.housing >= 0:
                a[site.housing] -= site.base_x
                a[site.housing + 1] -= site.base_y
    if k >= N_LOBATTO:
        return
    for axis in range(axes):
        force = 0.0
        for point in range(N_LOBATTO):
            force += LAGRANGE[point][k] * piece.x[first + axes * point + axis]
        if force != 0.0:
            row = int(matrices.ports[axis // 2]) + axis % 2
            if row < m:
                for i in range(m):
                    a[i] += w.Minv[row, i] * force
            else:
                for site in w.sites:
                    if site.housing == row - axis % 2:
                        a[row] += site.mobility * force


@kernel
def state_at(matrices: StepMatrices, n_terms: int, s: float, y: Array) -> None:
    """Write (q, v) after the share s of the piece into y."""
    terms = series_of(matrices).terms
    copy(terms[n_terms - 1], y)
    for k in range(n_terms - 2, -1, -1):
        term = terms[k]
        for i in range(term.shape[0]):
            y[i] = y[i] * s + term[i]


@kernel
def journal_at(matrices: StepMatrices, n_terms: int, s: float, site: Site) -> Point:
    """Return the motion of a site's journal relative to its retainer's centre, after the share s of the piece."""
    terms, n = series_of(matrices).terms, int(matrices.sizes[0].n)
    row, housing = site.row, site.housing
    x = y = v_x = v_y = 0.0
    for k in range(n_terms - 1, -1, -1):
        term = terms[k]
        x, y = x * s + term[row], y * s + term[row + 1]
        v_x, v_y = v_x * s + term[n + row], v_y * s + term[n + row + 1]
        if housing >= 0:
            x -= term[housing]
            y -= term[housing + 1]
            v_x -= term[n + housing]
            v_y -= term[n + housing + 1]
    return Point(x - site.offset_x, y - site.offset_y, v_x, v_y)


@kernel
def slip_at(matrices: StepMatrices, site: Site, k: int, n_terms: int, s: float) -> float:
    """Return the slip velocity (m/s) of a site after the share s of the piece."""
    piece, journal = piece_of(matrices), journal_at(matrices, n_terms, s, site)
    spin, races = piece.spin[0], piece.races[k]
    r = math.sqrt(journal.x * journal.x + journal.y * journal.y)
    slip = value_at(spin[0], spin[1], spin[2], spin[3], s) * site.journal_radius
    slip += (journal.x * journal.v_y - journal.y * journal.v_x) / r
    return slip - value_at(races[0], races[1], races[2], races[3], s) * race_radius(site)
