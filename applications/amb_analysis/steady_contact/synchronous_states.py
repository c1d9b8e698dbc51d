"""All steady synchronous states of a rotor with sites in contact; no branch is missed.

In the rotating frame, a forward rub at constant speed is at rest. Let r be the contact-free orbit and F_j = N_j (1 + i
mu_j) exp(i psi_j) the force of the rotor on each site. The displacement at the sites in contact is q = r - R F, so

    c_j p_j + sum_k rho_jk N_k p_k = r_j,    rho_jk = R_jk (1 + i mu_k),    p_j = exp(i psi_j)        (1)

where N_j > 0 at the sites in contact, and |q| < c at all other sites. Friction acts against the spin. With E = rho^-1
and s = E r,

    N_j = conj(p_j) (s_j - sum_k E_jk c_k p_k)   must be real                                         (2)

For a single site, N solves |rho|^2 N^2 + 2 c Re(rho) N + c^2 - |r|^2 = 0. For m sites, P replaces conj(p), so that (2)
and p P = 1 are 2 m equations that are linear in p and linear in P. The equations have C(2 m, m) complex solutions,
which is Bezout's number for two groups of unknowns. J. Baillieul and C. I. Byrnes, IEEE Trans. Circuits and Systems 29
(1982) 724-737, count the load flows of m + 1 electrical machines in this way, because load flows obey the same
equations. For two sites, the equations are solved with their resultant, which is of degree six. For three or more
sites, they are solved by homotopy continuation (`homotopy`). Solutions with |p| = 1 are the states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.homotopy import solve_by_paths
from array_types import Array, Bools

ON_CIRCLE = 1e-2  # distance of |p| from 1 up to which Newton's method checks a solution
SAME = 1e-7  # distance below which two solutions are equal
SETTLED = 1e-11  # residual of (2) relative to its terms
ITERATIONS = 12  # iterations of Newton's method
SINGULAR = 1e13  # condition number of rho above which forces at these sites cannot be distinguished


@dataclass(frozen=True, eq=False)
class States:
    """Synchronous states with a set of sites in contact, at many points.

    contact
        Indices of the sites in contact; empty for free states.
    points
        Index of each state's point, in ascending order, shape (n,).
    N
        Normal forces (N), shape (n, m).
    psi
        Angles of the journals from the reference of unbalance (rad), shape (n, m).
    q
        Displacements of all sites in the rotating frame (m), shape (n, n_sites).
    force
        Forces of the sites on the rotor (N), shape (n, n_sites).
    """

    contact: tuple[int, ...]
    points: NDArray[np.int64]
    N: Array
    psi: Array
    q: Complex
    force: Complex


def all_sets(n_sites: int, most: int | None = None) -> list[tuple[int, ...]]:
    """Return all sets of at most `most` sites in contact, beginning with the empty set."""
    highest = n_sites if most is None else min(most, n_sites)
    return [chosen for size in range(highest + 1) for chosen in combinations(range(n_sites), size)]


def states_of(contact: tuple[int, ...], R: Complex, mu: Array, c: Array, r: Complex) -> States:
    """Return all synchronous states with exactly this set of sites in contact; other arguments as `states_of_all`."""
    return states_of_all([contact], R, mu, c, r)[0]


def states_of_all(sets: Sequence[tuple[int, ...]], R: Complex, mu: Array, c: Array, r: Complex) -> list[States]:
    """Return all synchronous states (1) of each set of sites in contact; all sets of one size are solved together.

    Parameters
    ----------
    sets
        Indices of the sites in contact.
    R
        Receptances of all sites (m/N), shape (n_sites, n_sites), or per point (n_points, n_sites, n_sites).
    mu
        Friction coefficients (1), shape (n_sites,).
    c
        Clearances (m), shape (n_sites,).
    r
        Orbits of all sites without contact (m), shape (n_points, n_sites).
    """
    n = len(r)
    R_at_points = np.broadcast_to(R, (n, *R.shape[-2:]))
    solved: dict[tuple[int, ...], tuple[NDArray[np.int64], Complex, Array]] = {
        (): (np.arange(n), np.zeros((n, 0), dtype=complex), np.zeros((n, 0)))
    }
    for m in {len(contact) for contact in sets if contact}:
        alike = [contact for contact in sets if len(contact) == m]
        at = np.array(alike)
        rho = (R_at_points[:, at[:, :, None], at[:, None]] * (1.0 + 1j * mu[at])[:, None]).reshape(-1, m, m)
        row, p, N = _solutions(rho, np.tile(c[at], (n, 1)), r[:, at].reshape(-1, m))
        for k, contact in enumerate(alike):
            own = row % len(alike) == k
            solved[contact] = row[own] // len(alike), p[own], N[own]
    return [_apart(contact, *solved[contact], R_at_points, mu, c, r) for contact in sets]


def _apart(
    contact: tuple[int, ...],
    points: NDArray[np.int64],
    p: Complex,
    N: Array,
    R: Complex,
    mu: Array,
    c: Array,
    r: Complex,
) -> States:
    """Return the solutions that press outward at the sites in contact and do not reach the other sites."""
    at = list(contact)
    force = np.zeros((len(points), len(c)), dtype=complex)
    force[:, at] = -N * (1.0 + 1j * mu[at]) * p
    q = r[points] + np.einsum("nij,nj->ni", R[points], force)
    others = [k for k in range(len(c)) if k not in contact]
    apart = (np.abs(q[:, others]) < c[others]).all(axis=1) & (N > 0.0).all(axis=1)
    return States(contact, points[apart], N[apart], np.angle(p[apart]), q[apart], force[apart])


def _solutions(rho: Complex, c: Array, r: Complex) -> tuple[NDArray[np.int64], Complex, Array]:
    """Return point, p and N of all real solutions of (1), given rho, shape (n, m, m), and c and r, shape (n, m)."""
    m = r.shape[1]
    if m == 1:
        return _single(rho[:, 0, 0], c[:, 0], r[:, 0])
    scale = np.sqrt(np.abs(np.einsum("njj->nj", rho)))
    scale = np.where(scale > 0.0, scale, 1.0)
    regular = np.linalg.cond(rho / (scale[:, :, None] * scale[:, None, :])) < SINGULAR
    regular_points = np.flatnonzero(regular)
    if not len(regular_points):
        return np.zeros(0, dtype=np.int64), np.zeros((0, m), dtype=complex), np.zeros((0, m))
    E = np.linalg.inv(rho[regular_points])
    s, e = np.einsum("njk,nk->nj", E, r[regular_points]), E * c[regular_points, None]
    candidates = _pair(e, s) if m == 2 else solve_by_paths(e, s)
    row, k = np.nonzero((np.abs(np.abs(candidates) - 1.0) < ON_CIRCLE).all(axis=2))
    p, converged = _polished(np.asarray(np.angle(candidates[row, k]), dtype=np.float64), e[row], s[row])
    row, p = row[converged], p[converged]
    distinct = _distinct(row, p)
    row, p = row[distinct], p[distinct]
    N = (p.conj() * (s[row] - np.einsum("njk,nk->nj", e[row], p))).real
    return regular_points[row], p, N


def _single(rho: Complex, c: Array, r: Complex) -> tuple[NDArray[np.int64], Complex, Array]:
    """Return the positive roots N of the quadratic, computed without cancellation; there are none if rho = 0."""
    square, half = np.abs(rho) ** 2, c * rho.real
    rest = c * c - np.abs(r) ** 2
    discriminant = half**2 - square * rest
    real = (discriminant >= 0.0) & (square > 0.0)
    root = np.sqrt(np.where(real, discriminant, 0.0))
    large = -half - np.where(half >= 0.0, root, -root)  # of larger magnitude, times |rho|^2
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.stack([large / square, np.where(large != 0.0, rest / large, 0.0)], axis=1)
    roots.sort(axis=1)
    valid = real[:, None] & np.isfinite(roots)
    valid[:, 1] &= roots[:, 1] > roots[:, 0]
    points, k = np.nonzero(valid & (roots > 0.0))
    N = roots[points, k]
    p = r[points] / (c[points] + rho[points] * N)
    return points, (p / np.abs(p))[:, None], N[:, None]


def _pair(e: Complex, s: Complex) -> Complex:
    """Return candidates (p_1, p_2), shape (n, 24, 2): each root x of the resultant with each root y of both equations.

    For each site, (2) multiplied by p_1 p_2 is quadratic in y, where x = p_1 and y = p_2:

        -g y^2 + (s_1 - 2 i d_1 x - conj(s_1) x^2) y + conj(g) x^2 = 0,               g = E_12 c_2, d_1 = Im E_11 c_1
        (conj(h) - conj(s_2) x) y^2 - 2 i d_2 x y + s_2 x - h x^2 = 0,                h = E_21 c_1, d_2 = Im E_22 c_2
    """
    n = len(s)
    size = np.abs(e).sum(axis=2) + np.abs(s)  # scale each equation by its magnitude
    e, s = e / size[:, :, None], s / size
    g, h, d1, d2 = e[:, 0, 1], e[:, 1, 0], e[:, 0, 0].imag, e[:, 1, 1].imag
    s_1, s_2, zero = s[:, 0], s[:, 1], np.zeros(n, dtype=complex)
    a, b, k = [-g], [s_1, -2j * d1, -s_1.conj()], [zero, zero, g.conj()]
    a_, b_, k_ = [h.conj(), -s_2.conj()], [zero, -2j * d2], [zero, s_2, -h]
    first = _minus(_times(a, k_), _times(k, a_))
    resultant = _minus(
        _times(first, first), _times(_minus(_times(a, b_), _times(b, a_)), _minus(_times(b, k_), _times(k, b_)))
    )
    coefficients = np.stack(resultant[1:8], axis=1)  # the constant is 0: x^1 to x^7
    x = _roots(coefficients)
    g, h, s_1, s_2 = (v[:, None] for v in (g, h, s_1, s_2))
    ones, square, d1, d2 = np.ones_like(x), x**2, d1[:, None], d2[:, None]
    y = np.concatenate(
        [
            _quadratic(-g * ones, s_1 - 2j * d1 * x - s_1.conj() * square, g.conj() * square),
            _quadratic(h.conj() - s_2.conj() * x, -2j * d2 * x, s_2 * x - h * square),
        ],
        axis=2,
    )
    pairs = np.stack([np.broadcast_to(x[:, :, None], y.shape), y], axis=3).reshape(n, -1, 2)
    return np.where(np.isfinite(pairs), pairs, 0.0)


def _quadratic(a: Complex, b: Complex, c: Complex) -> Complex:
    """Return both roots of a y^2 + b y + c, without cancellation, on a new last axis."""
    root = np.sqrt(b**2 - 4.0 * a * c)
    far = -0.5 * (b + np.where((b.conj() * root).real >= 0.0, root, -root))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([far / a, c / far], axis=2)


def _times(p: list[Any], q: list[Any]) -> list[Any]:
    """Return the product of two polynomials with ascending coefficients, each an array over the points."""
    result = [0.0 * (p[0] + q[0])] * (len(p) + len(q) - 1)
    for i, left in enumerate(p):
        for j, right in enumerate(q):
            result[i + j] = result[i + j] + left * right
    return result


def _minus(p: list[Any], q: list[Any]) -> list[Any]:
    n = max(len(p), len(q))
    zero = 0.0 * p[0]
    p, q = p + [zero] * (n - len(p)), q + [zero] * (n - len(q))
    return [left - right for left, right in zip(p, q, strict=True)]


def _roots(coefficients: Complex) -> Complex:
    """Return the roots of polynomials with ascending coefficients, shape (n, degree + 1).

    The polynomials of decoupled sites have roots at 0 and at infinity. The roots are therefore computed after a Moebius
    map of the unit circle onto itself, which keeps the leading coefficient away from zero.
    """
    n, degree = coefficients.shape[0], coefficients.shape[1] - 1
    alpha = 0.37 + 0.21j  # x = (w + alpha)/(1 + conj(alpha) w)
    up = [np.array([alpha, 1.0])] * degree
    down = [np.array([1.0, np.conj(alpha)])] * degree
    mapped = np.zeros((n, degree + 1), dtype=complex)
    for k in range(degree + 1):
        basis = np.array([1.0 + 0j])
        for factor in up[:k] + down[k:]:
            basis = np.convolve(basis, factor)
        mapped += coefficients[:, k : k + 1] * basis
    companion = np.zeros((n, degree, degree), dtype=complex)
    companion[:, 1:, :-1] = np.eye(degree - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        companion[:, :, -1] = -mapped[:, :-1] / mapped[:, -1:]
    companion[~np.isfinite(companion).all(axis=(1, 2))] = 0.0
    w = np.linalg.eigvals(companion)
    return np.asarray((w + alpha) / (1.0 + np.conj(alpha) * w))


def _polished(psi: Array, e: Complex, s: Complex) -> tuple[Complex, Bools]:
    """Return p after Newton's method on the imaginary parts of (2), and whether each converged near its start."""
    start = np.exp(1j * psi)
    size = np.abs(e).sum(axis=2) + np.abs(s)
    m = psi.shape[1]
    p = start
    for _ in range(ITERATIONS):
        turned = e * p[:, None, :] * p.conj()[:, :, None]
        N = p.conj() * s - turned.sum(axis=2)
        J = -turned.real
        J[:, np.arange(m), np.arange(m)] -= N.real
        scaled = J / size[:, :, None] + 1e-15 * np.eye(m)
        step = np.linalg.solve(scaled, -(N.imag / size)[:, :, None])[:, :, 0]
        psi = psi + np.clip(step, -0.1, 0.1)
        p = np.exp(1j * psi)
    N = p.conj() * s - np.einsum("njk,nk->nj", e, p) * p.conj()
    converged = (np.abs(N.imag) < SETTLED * size).all(axis=1)
    return p, converged & (np.abs(p - start) < 10.0 * ON_CIRCLE).all(axis=1)


def _distinct(row: NDArray[np.int64], p: Complex) -> NDArray[np.int64]:
    """Return the ascending indices of solutions that differ from all earlier solutions at the same point."""
    distinct: list[int] = []
    for k in range(len(row)):
        back = len(distinct) - 1
        while back >= 0 and row[distinct[back]] == row[k]:
            if np.abs(p[distinct[back]] - p[k]).max() < SAME:
                break
            back -= 1
        else:
            distinct.append(k)
    return np.array(distinct, dtype=np.int64)
