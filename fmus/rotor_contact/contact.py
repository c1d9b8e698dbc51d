"""Contact as a constraint: multipliers and projection at several sites (thesis 4.10 to 4.21, 4.24 to 4.35).

            y ^    ___ retainer, radius of the gap c
              |  /     \\
              | |    o->|n     n outward normal, t = (-y, x)/r forward tangent (direction of spin)
              |  \\ ___ /      force on the rotor: -N n + T t, N >= 0
              +--------> x     sliding: T = -mu N sign(v_slip), v_slip = Omega R_s + t . v

Every site has two unknowns, N_k and T_k, and two equations in every mode (4.27 to 4.29):

    free       N_k = 0                           T_k = 0
    sliding    n_k . a_k = -|v_k|^2 / r_k        T_k + mu_k sign_k N_k = 0
    rolling    n_k . a_k = -|v_k|^2 / r_k        t_k . a_k = 0

The equation of N_k in contact is (4.15) divided by 2 r_k, that of T_k in rolling is (4.33) at constant spin speed. The
same equations, with other right-hand sides, give impulses (`impact`) and corrections (`project`).
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.interface import (
    CLEARANCE,
    FREE,
    JOURNAL_RADIUS,
    MU,
    N_SITES,
    OFFSET_X,
    OFFSET_Y,
    ROLLING,
    SITE_PARAMETERS,
)

# Columns of the table of sites; the parameters come first, in the order of the interface.
PLANE = SITE_PARAMETERS  # row of the site's x among the degrees of freedom
MODE = PLANE + 1  # free, sliding or rolling
SIGN = PLANE + 2  # of the slip that sliding friction opposes
RADIUS, N_X, N_Y = PLANE + 3, PLANE + 4, PLANE + 5  # distance of the journal from the centre, outward normal
NORMAL, TANGENTIAL = PLANE + 6, PLANE + 7  # contact forces of the last solution (N)
IMPULSE, LOSS = PLANE + 8, PLANE + 9  # impulse of impacts in this step (N s), energy lost in impacts so far (J)
P_N, P_T = PLANE + 10, PLANE + 11  # scratch: impulses
MARK, MODE_BEFORE, REBOUND = PLANE + 12, PLANE + 13, PLANE + 14  # scratch of events
SITE_COLUMNS = PLANE + 15

RHS = 2 * N_SITES  # the right-hand side is the last column of the equations


@kernel
def any_closed(sites: Array) -> bool:
    """Whether a site is in contact."""
    for k in range(N_SITES):
        if sites[k, MODE] != FREE:
            return True
    return False


@kernel
def locate(sites: Array, k: int, q: Array) -> float:
    """Radius r_k (m) of the journal about the centre of retainer k; notes it and its normal."""
    row = int(sites[k, PLANE])
    x = q[row] - sites[k, OFFSET_X]
    y = q[row + 1] - sites[k, OFFSET_Y]
    r = math.sqrt(x * x + y * y)
    sites[k, RADIUS] = r
    sites[k, N_X] = x / r if r > 0.0 else 1.0
    sites[k, N_Y] = y / r if r > 0.0 else 0.0
    return r


@kernel
def radial(sites: Array, k: int, v: Array) -> float:
    """Outward component n . v of `v` at site k (its normal must be up to date)."""
    row = int(sites[k, PLANE])
    component: float = sites[k, N_X] * v[row] + sites[k, N_Y] * v[row + 1]
    return component


@kernel
def tangential(sites: Array, k: int, v: Array) -> float:
    """Forward component t . v of `v` at site k (its normal must be up to date)."""
    row = int(sites[k, PLANE])
    component: float = sites[k, N_X] * v[row + 1] - sites[k, N_Y] * v[row]
    return component


@kernel
def slip_velocity(sites: Array, k: int, v: Array, Omega: float) -> float:
    """v_slip = Omega R_s + t . v (4.10), the velocity of the journal surface over the retainer (m/s)."""
    return Omega * sites[k, JOURNAL_RADIUS] + tangential(sites, k, v)


@kernel
def write_equations(Minv: Array, sites: Array, equations: Array, friction: float) -> None:
    """Left-hand sides for all sites in their modes, shape (2 n_sites, 2 n_sites + 1); right-hand sides are zeroed.

    Row 2 k belongs to N_k and row 2 k + 1 to T_k; a column holds the response M^-1 (-n) or M^-1 t. `friction` is 1, or
    0 to leave sliding friction out.
    """
    equations[:, :] = 0.0
    for k in range(N_SITES):
        if sites[k, MODE] == FREE:
            equations[2 * k, 2 * k] = 1.0
            equations[2 * k + 1, 2 * k + 1] = 1.0
            continue
        i = int(sites[k, PLANE])
        k_x = sites[k, N_X]
        k_y = sites[k, N_Y]
        for other in range(N_SITES):
            if sites[other, MODE] == FREE:
                continue
            j = int(sites[other, PLANE])
            n_x = sites[other, N_X]
            n_y = sites[other, N_Y]
            # response at site k, in x and y, to a unit force along n and along t at the other site
            xn = Minv[i, j] * n_x + Minv[i, j + 1] * n_y
            yn = Minv[i + 1, j] * n_x + Minv[i + 1, j + 1] * n_y
            xt = Minv[i, j + 1] * n_x - Minv[i, j] * n_y
            yt = Minv[i + 1, j + 1] * n_x - Minv[i + 1, j] * n_y
            equations[2 * k, 2 * other] = -(k_x * xn + k_y * yn)
            equations[2 * k, 2 * other + 1] = k_x * xt + k_y * yt
            if sites[k, MODE] == ROLLING:
                equations[2 * k + 1, 2 * other] = -(k_x * yn - k_y * xn)
                equations[2 * k + 1, 2 * other + 1] = k_x * yt - k_y * xt
        if sites[k, MODE] != ROLLING:
            equations[2 * k + 1, 2 * k] = friction * sites[k, MU] * sites[k, SIGN]
            equations[2 * k + 1, 2 * k + 1] = 1.0


@kernel
def solve(equations: Array) -> bool:
    """Gaussian elimination with partial pivoting; the solution replaces the right-hand side. False if singular."""
    n = equations.shape[0]
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(equations[r, i]) > abs(equations[best, i]):
                best = r
        if not abs(equations[best, i]) > 1e-300:
            return False
        if best != i:
            for c in range(i, n + 1):
                equations[i, c], equations[best, c] = equations[best, c], equations[i, c]
        for r in range(i + 1, n):
            ratio = equations[r, i] / equations[i, i]
            if ratio != 0.0:
                for c in range(i + 1, n + 1):
                    equations[r, c] -= ratio * equations[i, c]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            equations[i, n] -= equations[i, c] * equations[c, n]
        equations[i, n] /= equations[i, i]
    return True


@kernel
def push(Minv: Array, sites: Array, k: int, normal: float, forward: float, target: Array) -> None:
    """target += M^-1 (-normal n_k + forward t_k): acceleration by forces, or velocity by impulses."""
    j = int(sites[k, PLANE])
    f_x = -normal * sites[k, N_X] - forward * sites[k, N_Y]
    f_y = -normal * sites[k, N_Y] + forward * sites[k, N_X]
    for i in range(target.shape[0]):
        target[i] += Minv[i, j] * f_x + Minv[i, j + 1] * f_y


@kernel
def apply_contact(Minv: Array, sites: Array, equations: Array, q: Array, v: Array, a: Array) -> bool:
    """Solve the multipliers of all sites and add their effect to the free acceleration `a`; False if singular."""
    if not any_closed(sites):
        return True
    for k in range(N_SITES):
        locate(sites, k, q)
    write_equations(Minv, sites, equations, 1.0)
    for k in range(N_SITES):
        if sites[k, MODE] != FREE:
            i = int(sites[k, PLANE])
            curvature = (v[i] * v[i] + v[i + 1] * v[i + 1]) / sites[k, RADIUS]
            equations[2 * k, RHS] = -curvature - radial(sites, k, a)
            if sites[k, MODE] == ROLLING:
                equations[2 * k + 1, RHS] = -tangential(sites, k, a)
    if not solve(equations):
        return False
    for k in range(N_SITES):
        sites[k, NORMAL] = equations[2 * k, RHS]
        sites[k, TANGENTIAL] = equations[2 * k + 1, RHS]
        if sites[k, MODE] != FREE:
            push(Minv, sites, k, sites[k, NORMAL], sites[k, TANGENTIAL], a)
    return True


@kernel
def project(Minv: Array, sites: Array, equations: Array, q: Array, v: Array, Omega: float) -> bool:
    """Put closed sites back on the circle and onto the velocity constraint, by the mass-weighted smallest change.

    Without this the drift of the integrated constraint (4.14) grows with time. Friction plays no part in it. One Newton
    step is enough for positions: what a substep leaves is squared.
    """
    if not any_closed(sites):
        return True
    for target in range(2):
        for k in range(N_SITES):
            locate(sites, k, q)
        write_equations(Minv, sites, equations, 0.0)
        for k in range(N_SITES):
            if sites[k, MODE] == FREE:
                continue
            if target == 0:
                equations[2 * k, RHS] = sites[k, CLEARANCE] - sites[k, RADIUS]
            else:
                equations[2 * k, RHS] = -radial(sites, k, v)
                if sites[k, MODE] == ROLLING:
                    equations[2 * k + 1, RHS] = -slip_velocity(sites, k, v, Omega)
        if not solve(equations):
            return False
        for k in range(N_SITES):
            if sites[k, MODE] != FREE:
                push(Minv, sites, k, equations[2 * k, RHS], equations[2 * k + 1, RHS], q if target == 0 else v)
    return True
