"""All complex solutions of the equations for three or more sites in contact, by homotopy continuation.

    conj(p_j) (s_j - sum_k e_jk p_k)  real,  |p_j| = 1

If conj(p) is written as P, these become 2 m equations that are linear in p and linear in P:

    P_j (s_j - e_j p) - p_j (conj(s_j) - conj(e_j) P) = 0,      p_j P_j - 1 = 0                      (1)

A start system of products l_i(p) l'_i(P) of random linear forms has C(2 m, m) solutions, because in m of the equations
the form in p is zero, and in the others the form in P is zero. Along (1 - t) gamma start + t target, each path ends at
a solution of (1); for almost all gamma, no two paths meet (A. J. Sommese and C. W. Wampler, The Numerical Solution of
Systems of Polynomials, 2005, ch. 8).
"""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np

from amb_analysis.steady_contact.forward_loop import Complex

GAMMA = np.exp(2.1j)
FIRST_STEP, LEAST_STEP, LARGEST_STEP = 0.05, 1e-8, 0.1
TOLERANCE = 1e-8  # Newton step below which a point is on its path
FAR = 1e6  # size of a diverging solution
AT_A_TIME = 40000  # paths followed at once


def solve_by_paths(e: Complex, s: Complex) -> Complex:
    """Return p of all solutions of (1) at n points, shape (n, C(2 m, m), m); 0 where a path diverges.

    Parameters
    ----------
    e
        Coefficients e_jk at each point, shape (n, m, m).
    s
        Values s_j at each point, shape (n, m).
    """
    n, m = s.shape
    size = np.abs(e).sum(axis=2) + np.abs(s)
    e, s = e / size[:, :, None], s / size
    forms, starts = _start(m)
    paths = len(starts)
    assert paths == comb(2 * m, m)
    result = np.zeros((n, paths, m), dtype=complex)
    chunk = max(1, AT_A_TIME // paths)
    for begin in range(0, n, chunk):
        part = slice(begin, min(begin + chunk, n))
        count = part.stop - part.start
        at_e, at_s = np.repeat(e[part], paths, axis=0), np.repeat(s[part], paths, axis=0)
        z = _track(np.tile(starts, (count, 1)), at_e, at_s, forms)
        result[part] = z[:, :m].reshape(count, paths, m)
    return result


def _start(m: int) -> tuple[tuple[Complex, Complex], Complex]:
    """Return the coefficients and constants of the linear forms of the start system, and its solutions (p, P)."""
    random = np.random.default_rng(5)
    forms_p, forms_P = np.exp(2j * np.pi * random.random((2, 2 * m, m + 1)))
    result = []
    for chosen in combinations(range(2 * m), m):
        rest = [k for k in range(2 * m) if k not in chosen]
        first, second = forms_p[list(chosen)], forms_P[rest]
        p, P = (-np.linalg.solve(forms[:, :m], forms[:, m]) for forms in (first, second))
        result.append(np.concatenate([p, P]))
    return (forms_p, forms_P), np.array(result)


def _system(z: Complex, e: Complex, s: Complex) -> tuple[Complex, Complex]:
    """Return the left sides of (1) and their derivatives."""
    m = s.shape[1]
    p, P = z[:, :m], z[:, m:]
    left, right = s - np.einsum("njk,nk->nj", e, p), s.conj() - np.einsum("njk,nk->nj", e.conj(), P)
    J = np.zeros((len(z), 2 * m, 2 * m), dtype=complex)
    k = np.arange(m)
    J[:, :m, :m], J[:, :m, m:] = -P[:, :, None] * e, p[:, :, None] * e.conj()
    J[:, k, k] -= right
    J[:, k, m + k] += left
    J[:, m + k, k], J[:, m + k, m + k] = P, p
    return np.concatenate([P * left - p * right, p * P - 1.0], axis=1), J


def _start_system(z: Complex, forms: tuple[Complex, Complex]) -> tuple[Complex, Complex]:
    m = z.shape[1] // 2
    left = z[:, :m] @ forms[0][:, :m].T + forms[0][:, m]
    right = z[:, m:] @ forms[1][:, :m].T + forms[1][:, m]
    J = np.concatenate([right[:, :, None] * forms[0][:, :m], left[:, :, None] * forms[1][:, :m]], axis=2)
    return left * right, J


def _track(z: Complex, e: Complex, s: Complex, forms: tuple[Complex, Complex]) -> Complex:
    """Return the ends of paths, shape (n, 2 m), by Euler steps with Newton corrections; 0 where a path is lost."""
    t, h = np.zeros(len(z)), np.full(len(z), FIRST_STEP)
    active = np.arange(len(z))
    while len(active):
        now, at_e, at_s = t[active], e[active], s[active]
        step = np.minimum(h[active], 1.0 - now)
        y = z[active]
        tangent = _tangent(y, now, at_e, at_s, forms)
        half = y + 0.5 * step[:, None] * tangent
        moved = y + step[:, None] * _tangent(half, now + 0.5 * step, at_e, at_s, forms)
        for _ in range(3):
            value, J = _homotopy(moved, now + step, at_e, at_s, forms)
            change = _solve(J, value)
            moved = moved - change
        size = np.abs(moved).max(axis=1)
        good = (np.abs(change).max(axis=1) < TOLERANCE * np.maximum(size, 1.0)) & np.isfinite(size)
        z[active[good]], t[active[good]] = moved[good], (now + step)[good]
        h[active] = np.where(good, np.minimum(1.6 * step, LARGEST_STEP), 0.4 * step)
        lost = (~good & (step < LEAST_STEP)) | (good & (size > FAR))
        z[active[lost]] = 0.0
        active = active[~lost & (t[active] < 1.0)]
    return z


def _homotopy(
    z: Complex, t: np.ndarray, e: Complex, s: Complex, forms: tuple[Complex, Complex]
) -> tuple[Complex, Complex]:
    start, J_start = _start_system(z, forms)
    target, J_target = _system(z, e, s)
    left = (1.0 - t) * GAMMA
    return left[:, None] * start + t[:, None] * target, left[:, None, None] * J_start + t[:, None, None] * J_target


def _tangent(z: Complex, t: np.ndarray, e: Complex, s: Complex, forms: tuple[Complex, Complex]) -> Complex:
    J = _homotopy(z, t, e, s, forms)[1]
    over_t = _system(z, e, s)[0] - GAMMA * _start_system(z, forms)[0]
    return -_solve(J, over_t)


def _solve(J: Complex, value: Complex) -> Complex:
    """Return J^-1 value for each path; NaN where J is singular, so that `_track` takes a shorter step."""
    regular = J + 1e-300 * np.eye(J.shape[1])
    try:
        return np.linalg.solve(regular, value[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        result = np.full(value.shape, np.nan, dtype=complex)
        solvable = np.linalg.slogdet(regular)[0] != 0.0
        result[solvable] = np.linalg.solve(regular[solvable], value[solvable, :, None])[:, :, 0]
        return result
