"""The matrices of exact motion over one piece of a step, by Taylor series in time: the motion from each unit of x.

x are the state, steady forces, the direction of the unbalance, and contact forces at the Lobatto points. Forces have
these courses over time:

    steady 1,    unbalance cos(Omega t) and sin(Omega t),    contact l_j(t/h)

l_j being the cubic that is 1 at Lobatto point j and 0 at the others.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, kernel_apart
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.dynamics import Motion, coefficients, forces
from rotor_contact.lobatto import LAGRANGE, LOBATTO_POINTS, N_LOBATTO
from rotor_contact.products import row_combination
from rotor_contact.propagator import N_GAUSS, N_SEEN, Key, Propagator, is_begun, n_free, set_key
from rotor_contact.site import Sites
from rotor_contact.structure import REAL

LONGEST_PIECE = 2.0  # times how fast anything can change
MAX_PIECES = 16
SMALLEST_TERM = 1e-20  # of the series, which ends there; its terms fall at least like (rate h)^k/k!
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)  # in [0, 1]

# t^k of a term, t being the Gauss points and the Lobatto points after the first, over the length of the piece.
Powers = tuple[float, float, float, float, float, float, float]


@kernel_apart
def build_rows(Minv: Array, motion: Motion, sites: Sites, key: Key, propagator: Propagator, share: float) -> None:
    """Build P, V and S for this key until a share of them, from 0 to 1, is there.

    To build a little in each step keeps the longest step short. The motion must have the coefficients of the key.
    """
    built, n = propagator.built[0], Minv.shape[0]
    if not is_begun(propagator, key):
        set_key(propagator.key, key)
        _begin(motion, propagator)
    while built.n_rows < share * propagator.P.shape[0]:
        row = int(built.n_rows)
        if not 3 * n <= row < n_free(n):
            _integrate_unit(Minv, motion, sites, propagator, row)
        built.n_rows += 1.0


@kernel
def _begin(motion: Motion, propagator: Propagator) -> None:
    """Find how many pieces a step needs, and how many terms their series."""
    K, C = coefficients(motion)
    n = K.shape[0]
    elastic = viscous = 0.0  # the largest row sums bound how fast anything can change
    for i in range(n):
        row_of_K = row_of_C = 0.0
        for j in range(n):
            row_of_K += abs(K[j, i])
            row_of_C += abs(C[j, i])
        elastic, viscous = max(elastic, row_of_K), max(viscous, row_of_C)
    rate = math.sqrt(elastic) + viscous + abs(motion.Omega)
    built, step_size = propagator.built[0], propagator.key.own[0].step_size
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
    """Write the two rows of the unbalance, and what its work takes of x, where the unbalance has changed.

    The force is p cos(Omega t) + r sin(Omega t) with p = A c + B s and r = A s - B c (c `cosine`, s `sine`), so its
    work is p V_c + r V_s = A (c V_c + s V_s) + B (s V_c - c V_s).
    """
    _, cosine, sine, _ = forces(motion)
    n = cosine.shape[0]
    known = propagator.unbalance
    if not (same_bits(cosine, known[:n]) and same_bits(sine, known[n:])):
        _direct_unbalance(cosine, sine, propagator)


@kernel_apart
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
def _integrate_unit(Minv: Array, motion: Motion, sites: Sites, propagator: Propagator, unit: int) -> None:
    """Taylor-integrate one row's unit of displacement, velocity or force over a piece, term by term in t/h.

    The rows of `series` are the terms of q, v, of the real and imaginary part of int v exp(i Omega (h - t)) dt, and the
    acceleration.
    """
    n, h = Minv.shape[0], propagator.built[0].length
    K, C = coefficients(motion)
    row, integral, series = propagator.P[unit], propagator.V[unit], propagator.series
    row[:] = 0.0
    integral[:] = 0.0
    series[:, :] = 0.0
    q, v, re, im, a = series[0], series[1], series[2], series[3], series[4]
    n_x = propagator.start.shape[0]
    kind, column = unit // n - 2, unit % n  # -2, -1: displacement, velocity; 0, 1, 2: steady, cosine, sine
    point = -1
    if unit >= n_x:
        kind, column = 1 + (unit - n_x) // n, (unit - n_x) % n
    elif unit >= n_free(n):
        kind = 3
        point, at = (unit - n_free(n)) // (2 * sites.shape[0]), (unit - n_free(n)) % (2 * sites.shape[0])
        column = sites[at // 2].row + at % 2
    if kind < 0:
        series[kind + 2, column] = 1.0
        row[unit] = 1.0
    powers: Powers = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    propagator.S[:, unit, 2:] = 0.0
    _observe_term(motion, sites, propagator, unit, powers)
    cosine, sine = 1.0, 0.0
    q_and_v = part(series, 0, REAL, 2 * n)
    for term in range(1, int(propagator.built[0].n_terms) + 1):
        dt, delta_theta = h / term, 0.0 if kind == 0 else motion.Omega * h / term
        force = 0.0 if kind < 0 else sine if kind == 2 else cosine
        if point >= 0:
            force = LAGRANGE[point][term - 1] if term <= N_LOBATTO else 0.0
        cosine, sine = -delta_theta * sine, delta_theta * cosine
        row_combination(q_and_v, motion.rows[: 2 * n], a, n)
        for i in range(n):
            a[i] = force * Minv[i, column] - a[i]
        if term == 1:
            for k in range(sites.shape[0]):
                propagator.S[k, unit, 0] = a[sites[k].row]
                propagator.S[k, unit, 1] = a[sites[k].row + 1]
        for i in range(n):
            real = dt * (v[i] - motion.Omega * im[i])
            im[i] = dt * motion.Omega * re[i]
            re[i] = real
            q[i] = dt * v[i]
            v[i] = dt * a[i]
            row[i] += q[i]
            row[n + i] += v[i]
            integral[i] += re[i]
            integral[n + i] += im[i]
        powers = _next(powers)
        _observe_term(motion, sites, propagator, unit, powers)
    cosine, sine = math.cos(motion.Omega * h), math.sin(motion.Omega * h)
    force = 1.0 if kind == 0 else cosine if kind == 1 else sine if kind == 2 else 0.0
    for k in range(sites.shape[0]):
        for axis in range(2):
            i = sites[k].row + axis
            acceleration = force * Minv[i, column]
            for j in range(n):
                acceleration -= K[j, i] * row[j] + C[j, i] * row[n + j]
            propagator.S[k, unit, N_SEEN - 2 + axis] = acceleration
    for i in range(n):  # from int v exp(i Omega (h - t)) dt to V_c and V_s
        real, imaginary = integral[i], integral[n + i]
        integral[i] = real * cosine + imaginary * sine
        integral[n + i] = real * sine - imaginary * cosine


@kernel
def _next(powers: Powers) -> Powers:
    """Return the powers of the next term."""
    a, b, c, d, e, f, g = powers
    _, first, second, last = LOBATTO_POINTS
    u, v, w, x = GAUSS_POINTS
    return a * u, b * v, c * w, d * x, e * first, f * second, g * last


@kernel
def _observe_term(motion: Motion, sites: Sites, propagator: Propagator, unit: int, powers: Powers) -> None:
    """Add a term of the series to what is observed between both ends: by the dampers, and by the sites."""
    n = motion.rows.shape[1]
    q, v, row = propagator.series[0], propagator.series[1], propagator.P[unit]
    for k in range(N_GAUSS):
        for b in range(n_observed(motion)):
            row[2 * n + k * n_observed(motion) + b] += powers[k] * observed(motion, q, v, b)
    for k in range(sites.shape[0]):
        seen, i = propagator.S[k, unit], sites[k].row
        for point in range(1, N_LOBATTO):
            power, at = powers[N_GAUSS + point - 1], 4 * point - 2
            seen[at] += power * q[i]
            seen[at + 1] += power * q[i + 1]
            seen[at + 2] += power * v[i]
            seen[at + 3] += power * v[i + 1]


@kernel
def n_observed(motion: Motion) -> int:
    """Return how many numbers of q and v the heat of damping takes: all, or the velocities at the bearings' axes."""
    return 2 * motion.rows.shape[1] if motion.is_damped else n_axes(motion)


@kernel
def observed(motion: Motion, q: Array, v: Array, b: int) -> float:
    """Return number b of those of `n_observed`."""
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
