"""The matrices of exact motion over a piece of a step, by Taylor series in time: the motion due to each unit of x.

x contains the state, steady forces, the direction of the unbalance, and contact forces at the Lobatto points. Forces
vary over time as

    steady 1,    unbalance cos(Omega t) and sin(Omega t),    contact l_j(t/h)

where l_j is the cubic that is 1 at Lobatto point j and 0 at the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.dynamics import Motion, coefficients, forces
from rotor_contact.lobatto import LAGRANGE, LOBATTO_POINTS, N_LOBATTO
from rotor_contact.products import row_combination
from rotor_contact.propagator import N_GAUSS, Key, Propagator, is_begun, n_free, observed
from rotor_contact.site import Sites
from rotor_contact.structure import REAL

LONGEST_PIECE = 2.0  # length times the highest rate of change
MAX_PIECES = 16
SMALLEST_TERM = 1e-20  # of the series, which ends at it; its terms fall at least like (rate h)^k/k!
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)  # in [0, 1]

# A row of P is the response to a unit of displacement, of velocity, or of a force with the time course above. The two
# of kind `UNBALANCE` are computed from those of `COSINE` and `SINE` by `direct_unbalance`.
DISPLACEMENT, VELOCITY, STEADY, UNBALANCE, COSINE, SINE, CONTACT = range(7)


class Basis(NamedTuple):
    """A unit of x: its kind, the degree of freedom that it acts on, and the Lobatto point of a contact force."""

    kind: int
    column: int
    point: int


# t^k of a term, t being the Gauss points and the Lobatto points after the first, over the length of the piece.
Powers = tuple[float, float, float, float, float, float, float]


@noinline_kernel
def build_rows(Minv: Array, motion: Motion, sites: Sites, key: Key, propagator: Propagator, share: float) -> None:
    """Build P, V and S for this key until a share of them, from 0 to 1, is built.

    Building a little in each step keeps the longest step short. The motion must have the coefficients of the key.
    """
    built, n = propagator.built[0], Minv.shape[0]
    if not is_begun(propagator, key):
        copy(key.values, propagator.key.values)
        _begin(motion, propagator)
    while built.n_rows < share * propagator.P.shape[0]:
        row = int(built.n_rows)
        basis = basis_of(row, n, propagator.start.shape[0], sites)
        if basis.kind != UNBALANCE:
            _integrate_basis_column(Minv, motion, sites, propagator, row, basis)
        built.n_rows += 1.0


@kernel
def _begin(motion: Motion, propagator: Propagator) -> None:
    """Find the number of pieces per step, and of terms of their series."""
    K, C = coefficients(motion)
    n = K.shape[0]
    elastic = viscous = 0.0  # the largest row sums, which bound the rates of change
    for i in range(n):
        row_of_K = row_of_C = 0.0
        for j in range(n):
            row_of_K += abs(K[j, i])
            row_of_C += abs(C[j, i])
        elastic, viscous = max(elastic, row_of_K), max(viscous, row_of_C)
    rate = math.sqrt(elastic) + viscous + abs(motion.Omega)
    built, step_size = propagator.built[0], propagator.key.step[0].step_size
    built.n_pieces = built.n_rows = built.n_terms = 0.0
    propagator.unbalance[0] = math.nan  # the two rows of the unbalance are not those of this P
    if not step_size * rate <= LONGEST_PIECE * MAX_PIECES:
        built.n_rows = propagator.P.shape[0]  # nothing is left to do
        return
    built.n_pieces = max(math.ceil(step_size * rate / LONGEST_PIECE), 1)
    built.length = step_size / built.n_pieces
    term = 1.0
    while term > SMALLEST_TERM or built.n_terms < N_LOBATTO:
        built.n_terms += 1.0
        term *= rate * built.length / built.n_terms


@kernel
def direct_unbalance(motion: Motion, propagator: Propagator) -> None:
    """Write the two rows of the unbalance, and the coefficients of its work, if the unbalance has changed.

    The force is p cos(Omega t) + r sin(Omega t) with p = A c + B s and r = A s - B c (c `cosine`, s `sine`), so its
    work is p V_c + r V_s = A (c V_c + s V_s) + B (s V_c - c V_s).
    """
    _, cosine, sine, _ = forces(motion)
    n = cosine.shape[0]
    reference = propagator.unbalance
    if not (same_bits(cosine, reference[:n]) and same_bits(sine, reference[n:])):
        _direct_unbalance(cosine, sine, propagator)


@noinline_kernel
def _direct_unbalance(cosine: Array, sine: Array, propagator: Propagator) -> None:
    n = cosine.shape[0]
    copy(cosine, propagator.unbalance)
    copy(sine, propagator.unbalance[n:])
    _combine(cosine, sine, propagator.P, n)
    _combine(cosine, sine, propagator.V, n)
    for k in range(propagator.S.shape[0]):
        _combine(cosine, sine, propagator.S[k], n)
    for j in range(propagator.start.shape[0]):
        a = b = 0.0
        for i in range(n):
            V_c, V_s = propagator.V[j, i], propagator.V[j, n + i]
            a += cosine[i] * V_c + sine[i] * V_s
            b += sine[i] * V_c - cosine[i] * V_s
        propagator.work[0, j], propagator.work[1, j] = a, b


@kernel
def _combine(cosine: Array, sine: Array, matrix: Array, n: int) -> None:
    """Write the rows for A = 1 and for B = 1 into a matrix, from its last 2 n rows."""
    A, B, units = matrix[3 * n], matrix[3 * n + 1], matrix.shape[0] - 2 * n
    A[:] = 0.0
    B[:] = 0.0
    for i in range(n):
        c, s = cosine[i], sine[i]
        if c != 0.0 or s != 0.0:
            for j in range(matrix.shape[1]):
                of_cosine, of_sine = matrix[units + i, j], matrix[units + n + i, j]
                A[j] += c * of_cosine + s * of_sine
                B[j] += s * of_cosine - c * of_sine


@kernel
def basis_of(row: int, n: int, n_x: int, sites: Sites) -> Basis:
    """Return the unit that a row of P responds to; `n_x` is the number of rows of x."""
    if row >= n_x:
        return Basis(COSINE + (row - n_x) // n, (row - n_x) % n, 0)
    if row >= n_free(n):
        axes, number = 2 * sites.shape[0], row - n_free(n)
        axis = number % axes
        return Basis(CONTACT, sites[axis // 2].row + axis % 2, number // axes)
    return Basis(row // n, row % n, 0)


@kernel
def _integrate_basis_column(
    Minv: Array, motion: Motion, sites: Sites, propagator: Propagator, row: int, basis: Basis
) -> None:
    """Taylor-integrate the response to a unit of x over a piece, term by term in t/h, into a row of P, V and S.

    The rows of `series` are the terms of q, v, of the real and imaginary part of int v exp(i Omega (h - t)) dt, and the
    acceleration.
    """
    n, h, Omega = Minv.shape[0], propagator.built[0].length, motion.Omega
    response, integral, series = propagator.P[row], propagator.V[row], propagator.series
    response[:] = 0.0
    integral[:] = 0.0
    series[:, :] = 0.0
    propagator.S[:, row, 2:] = 0.0
    q, v, re, im, a = series[0], series[1], series[2], series[3], series[4]
    if basis.kind == DISPLACEMENT or basis.kind == VELOCITY:
        series[basis.kind, basis.column] = 1.0
        response[row] = 1.0
    powers: Powers = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    _observe_term(motion, sites, propagator, row, powers)
    cosine, sine = 1.0, 0.0  # terms of cos(Omega t) and sin(Omega t), or of 1 and 0
    q_and_v = part(series, 0, REAL, 2 * n)
    for term in range(1, int(propagator.built[0].n_terms) + 1):
        dt, delta_theta = h / term, 0.0 if basis.kind == STEADY else Omega * h / term
        force = _force_term(basis, term, cosine, sine)
        cosine, sine = -delta_theta * sine, delta_theta * cosine
        row_combination(q_and_v, motion.rows[: 2 * n], a, n)
        for i in range(n):
            a[i] = force * Minv[i, basis.column] - a[i]
        if term == 1:
            for k in range(sites.shape[0]):
                at_site = observed(propagator.S[k, row])
                at_site.a_start[0], at_site.a_start[1] = a[sites[k].row], a[sites[k].row + 1]
        for i in range(n):
            real = dt * (v[i] - Omega * im[i])
            im[i] = dt * Omega * re[i]
            re[i] = real
            q[i] = dt * v[i]
            v[i] = dt * a[i]
            response[i] += q[i]
            response[n + i] += v[i]
            integral[i] += re[i]
            integral[n + i] += im[i]
        powers = _next(powers)
        _observe_term(motion, sites, propagator, row, powers)
    _observe_end(Minv, motion, sites, propagator, row, basis)
    cosine, sine = math.cos(Omega * h), math.sin(Omega * h)
    for i in range(n):  # from int v exp(i Omega (h - t)) dt to V_c and V_s
        real, imaginary = integral[i], integral[n + i]
        integral[i] = real * cosine + imaginary * sine
        integral[n + i] = real * sine - imaginary * cosine


@kernel
def _force_term(basis: Basis, term: int, cosine: float, sine: float) -> float:
    """Return the coefficient of (t/h)^(term - 1) of the unit force; `cosine` and `sine` are its two coefficients."""
    if basis.kind == CONTACT:
        return LAGRANGE[basis.point][term - 1] if term <= N_LOBATTO else 0.0
    if basis.kind == STEADY or basis.kind == COSINE:
        return cosine
    return sine if basis.kind == SINE else 0.0


@kernel
def _observe_end(Minv: Array, motion: Motion, sites: Sites, propagator: Propagator, row: int, basis: Basis) -> None:
    """Write the accelerations of the sites at the end of a piece into S; without contact forces."""
    K, C = coefficients(motion)
    n, angle, response = Minv.shape[0], motion.Omega * propagator.built[0].length, propagator.P[row]
    force = 1.0 if basis.kind == STEADY else 0.0
    if basis.kind == COSINE:
        force = math.cos(angle)
    elif basis.kind == SINE:
        force = math.sin(angle)
    for k in range(sites.shape[0]):
        at_site = observed(propagator.S[k, row])
        for axis in range(2):
            i = sites[k].row + axis
            acceleration = force * Minv[i, basis.column]
            for j in range(n):
                acceleration -= K[j, i] * response[j] + C[j, i] * response[n + j]
            at_site.a_end[axis] = acceleration


@kernel
def _next(powers: Powers) -> Powers:
    """Return the powers of the next term."""
    a, b, c, d, e, f, g = powers
    _, first, second, last = LOBATTO_POINTS
    u, v, w, x = GAUSS_POINTS
    return a * u, b * v, c * w, d * x, e * first, f * second, g * last


@kernel
def _observe_term(motion: Motion, sites: Sites, propagator: Propagator, row: int, powers: Powers) -> None:
    """Add a term of the series to the observations between both ends, for the dampers and the sites."""
    n, n_dampers = motion.rows.shape[1], n_observed(motion)
    q, v, response = propagator.series[0], propagator.series[1], propagator.P[row]
    for point in range(N_GAUSS):
        for b in range(n_dampers):
            response[2 * n + point * n_dampers + b] += powers[point] * damper_motion(motion, q, v, b)
    for k in range(sites.shape[0]):
        at_site, i = observed(propagator.S[k, row]), sites[k].row
        for point in range(N_LOBATTO - 1):
            power, journal = powers[N_GAUSS + point], at_site.journal[point]
            journal.x += power * q[i]
            journal.y += power * q[i + 1]
            journal.v_x += power * v[i]
            journal.v_y += power * v[i + 1]


@kernel
def n_observed(motion: Motion) -> int:
    """Return the number of values for the heat of damping: all of q and v, or the velocities at the bearings."""
    return 2 * motion.rows.shape[1] if motion.is_damped else n_axes(motion)


@kernel
def damper_motion(motion: Motion, q: Array, v: Array, b: int) -> float:
    """Return value b of those counted by `n_observed`."""
    n = motion.rows.shape[1]
    if motion.is_damped:
        number: float = q[b] if b < n else v[b - n]
        return number
    velocity: float = v[row_of_axis(motion, b)]
    return velocity


@kernel
def n_axes(motion: Motion) -> int:
    """Return the number of the bearings' axes."""
    return 2 * motion.bearings.shape[0]


@kernel
def row_of_axis(motion: Motion, b: int) -> int:
    """Return the degree of freedom of axis b of the bearings: x and y of the first, then of the next."""
    row: int = motion.bearings[b // 2].row + b % 2
    return row
