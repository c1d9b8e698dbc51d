"""Contact as a constraint: multipliers, impacts and projection at several sites (thesis 4.10 to 4.35).

            y ^    ___ retainer, radius of the gap c
              |  /     \\
              | |    o->|n     n outward normal, t = (-y, x)/r forward tangent (direction of spin)
              |  \\ ___ /      force on the rotor: -N n + T t, N >= 0
              +--------> x     sliding: T = -mu N sign(v_slip), v_slip = Omega R_s + t . v

At each closed site k the normal row of the constraint is n_k . a_k = -|v_k|^2 / r_k (4.15, divided by 2 r_k), and a
rolling site has the row t_k . a_k = 0 (4.33; the spin speed is constant within a step). The unknowns are N_k, and T_k
where the site rolls. Rows of open sites are left out, which is the same as lambda_k = 0 (4.27 to 4.29).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.constants import Structure
from rotor_contact.interface import FREE, N_SITES, ROLLING, SLIDING

N_UNKNOWNS = 2 * N_SITES


class Sites(NamedTuple):
    """State and scratch of the contact sites; arrays of shape (n_sites,) unless stated.

    clearance, mu, restitution, journal_radius, offset_x, offset_y
        Parameters, SI units.
    mode
        0 free, 1 sliding, 2 rolling.
    sign
        Direction of slip that sliding friction opposes, +1 or -1.
    normal, tangential
        Contact forces N and T of the last solution (N).
    impulse, loss
        Normal impulse (N s) of the impacts since the beginning of the step, and their energy loss (J), shape (1,).
    normals
        n_x, n_y of each site, shape (2 n_sites,).
    P_n, P_t, mark, mode_before, rebound
        Scratch: unknowns of impacts and projections, which sites touch, their modes before, their restitution now.
    A, b
        Scratch for the multipliers, shapes (2 n_sites, 2 n_sites) and (2 n_sites,).
    """

    clearance: Array
    mu: Array
    restitution: Array
    journal_radius: Array
    offset_x: Array
    offset_y: Array
    mode: Array
    sign: Array
    normal: Array
    tangential: Array
    impulse: Array
    loss: Array
    normals: Array
    P_n: Array
    P_t: Array
    mark: Array
    mode_before: Array
    rebound: Array
    A: Array
    b: Array


@kernel
def locate(s: Structure, sites: Sites, k: int, q: Array) -> float:
    """Radius r_k (m) of the journal about the centre of retainer k; writes its unit normal."""
    row = int(s.rows[k])
    x = q[row] - sites.offset_x[k]
    y = q[row + 1] - sites.offset_y[k]
    r = math.sqrt(x * x + y * y)
    if r > 0.0:
        sites.normals[2 * k] = x / r
        sites.normals[2 * k + 1] = y / r
    else:
        sites.normals[2 * k] = 1.0
        sites.normals[2 * k + 1] = 0.0
    return r


@kernel
def radial(s: Structure, sites: Sites, k: int, v: Array) -> float:
    """Outward component n . v of `v` at site k (its normal must be up to date)."""
    row = int(s.rows[k])
    return sites.normals[2 * k] * v[row] + sites.normals[2 * k + 1] * v[row + 1]


@kernel
def tangential(s: Structure, sites: Sites, k: int, v: Array) -> float:
    """Forward component t . v of `v` at site k (its normal must be up to date)."""
    row = int(s.rows[k])
    return sites.normals[2 * k] * v[row + 1] - sites.normals[2 * k + 1] * v[row]


@kernel
def slip_velocity(s: Structure, sites: Sites, k: int, v: Array, Omega: float) -> float:
    """v_slip = Omega R_s + t . v (4.10), the velocity of the journal surface over the retainer (m/s)."""
    return Omega * sites.journal_radius[k] + tangential(s, sites, k, v)


@kernel
def solve(A: Array, b: Array, n: int) -> bool:
    """Solve A x = b in place by elimination with partial pivoting; False if A is singular."""
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(A[r, i]) > abs(A[best, i]):
                best = r
        if not abs(A[best, i]) > 1e-300:
            return False
        if best != i:
            for c in range(n):
                A[i, c], A[best, c] = A[best, c], A[i, c]
            b[i], b[best] = b[best], b[i]
        for r in range(i + 1, n):
            ratio = A[r, i] / A[i, i]
            for c in range(i, n):
                A[r, c] -= ratio * A[i, c]
            b[r] -= ratio * b[i]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            b[i] -= A[i, c] * b[c]
        b[i] /= A[i, i]
    return True


@kernel
def assemble_rows(s: Structure, sites: Sites, with_friction: float) -> None:
    """Fill `A` with the response of the constrained directions to the contact unknowns.

    Unknowns in order: N_k of each closed site, followed by T_k where it rolls. Row of N_k: n_k, row of T_k: t_k.
    Column of N_k: M^-1 (-n_k - mu sign t_k) while sliding, M^-1 (-n_k) while rolling; column of T_k: M^-1 t_k.
    `with_friction` is 1, or 0 to leave sliding friction out.
    """
    row = 0
    for k in range(N_SITES):
        if sites.mode[k] == FREE:
            continue
        i = int(s.rows[k])
        for direction in range(2 if sites.mode[k] == ROLLING else 1):
            e_x = sites.normals[2 * k] if direction == 0 else -sites.normals[2 * k + 1]
            e_y = sites.normals[2 * k + 1] if direction == 0 else sites.normals[2 * k]
            column = 0
            for other in range(N_SITES):
                if sites.mode[other] == FREE:
                    continue
                j = int(s.rows[other])
                n_x = sites.normals[2 * other]
                n_y = sites.normals[2 * other + 1]
                d_x = -n_x
                d_y = -n_y
                if sites.mode[other] == SLIDING:
                    friction = with_friction * sites.mu[other] * sites.sign[other]
                    d_x += friction * n_y
                    d_y -= friction * n_x
                sites.A[row, column] = e_x * (s.Minv[i, j] * d_x + s.Minv[i, j + 1] * d_y) + e_y * (
                    s.Minv[i + 1, j] * d_x + s.Minv[i + 1, j + 1] * d_y
                )
                column += 1
                if sites.mode[other] == ROLLING:
                    sites.A[row, column] = e_x * (-s.Minv[i, j] * n_y + s.Minv[i, j + 1] * n_x) + e_y * (
                        -s.Minv[i + 1, j] * n_y + s.Minv[i + 1, j + 1] * n_x
                    )
                    column += 1
            row += 1


@kernel
def read_unknowns(sites: Sites, P_n: Array, P_t: Array) -> None:
    """Unpack the solution into normal and tangential parts, for every site (zero where it is free)."""
    row = 0
    for k in range(N_SITES):
        P_n[k] = 0.0
        P_t[k] = 0.0
        if sites.mode[k] == FREE:
            continue
        P_n[k] = sites.b[row]
        row += 1
        if sites.mode[k] == ROLLING:
            P_t[k] = sites.b[row]
            row += 1
        else:
            P_t[k] = -sites.mu[k] * sites.sign[k] * P_n[k]


@kernel
def push(s: Structure, sites: Sites, k: int, normal: float, forward: float, target: Array) -> None:
    """target += M^-1 (-normal n_k + forward t_k): acceleration by forces, or velocity by impulses."""
    j = int(s.rows[k])
    f_x = -normal * sites.normals[2 * k] - forward * sites.normals[2 * k + 1]
    f_y = -normal * sites.normals[2 * k + 1] + forward * sites.normals[2 * k]
    for i in range(target.shape[0]):
        target[i] += s.Minv[i, j] * f_x + s.Minv[i, j + 1] * f_y


@kernel
def apply_contact(s: Structure, sites: Sites, q: Array, v: Array, a: Array) -> bool:
    """Solve the multipliers of all closed sites and add their effect to the acceleration `a`; False if singular."""
    row = 0
    for k in range(N_SITES):
        if sites.mode[k] == FREE:
            continue
        r = locate(s, sites, k, q)
        i = int(s.rows[k])
        sites.b[row] = -(v[i] * v[i] + v[i + 1] * v[i + 1]) / r - radial(s, sites, k, a)
        row += 1
        if sites.mode[k] == ROLLING:
            sites.b[row] = -tangential(s, sites, k, a)
            row += 1
    if row > 0:
        assemble_rows(s, sites, 1.0)
        if not solve(sites.A, sites.b, row):
            return False
    read_unknowns(sites, sites.normal, sites.tangential)
    for k in range(N_SITES):
        if sites.mode[k] != FREE:
            push(s, sites, k, sites.normal[k], sites.tangential[k], a)
    return True


@kernel
def project(s: Structure, sites: Sites, q: Array, v: Array, Omega: float) -> bool:
    """Put closed sites back on the circle and onto the velocity constraint, by the mass-weighted smallest change.

    Without this the drift of the integrated constraint (4.14) grows with time. Friction plays no part in it.
    """
    for repeat in range(3):
        row = 0
        for k in range(N_SITES):
            if sites.mode[k] == FREE:
                continue
            r = locate(s, sites, k, q)
            if repeat < 2:
                sites.b[row] = sites.clearance[k] - r
            else:
                sites.b[row] = -radial(s, sites, k, v)
            row += 1
            if sites.mode[k] == ROLLING:
                sites.b[row] = 0.0 if repeat < 2 else -slip_velocity(s, sites, k, v, Omega)
                row += 1
        if row == 0:
            return True
        assemble_rows(s, sites, 0.0)
        if not solve(sites.A, sites.b, row):
            return False
        read_unknowns(sites, sites.P_n, sites.P_t)
        for k in range(N_SITES):
            if sites.mode[k] == FREE:
                continue
            forward = sites.P_t[k] if sites.mode[k] == ROLLING else 0.0
            if repeat < 2:
                push(s, sites, k, sites.P_n[k], forward, q)
            else:
                push(s, sites, k, sites.P_n[k], forward, v)
    return True
