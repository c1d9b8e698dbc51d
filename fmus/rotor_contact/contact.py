"""Contact as a constraint: multipliers and projection at several sites (thesis 4.10 to 4.21, 4.24 to 4.35).

            y ^    ___ retainer, radius of the gap c
              |  /     \\
              | |    o->|n     n outward normal, t = (-y, x)/r forward tangent (direction of spin)
              |  \\ ___ /      force on the rotor: -N n + T t, N >= 0
              +--------> x     sliding: T = -mu N sign(v_slip), v_slip = Omega R_s + t . v

Every site has two unknowns, N_k and T_k, and two equations in every mode (4.27 to 4.29):

    free       N_k = 0                           T_k = 0
    sliding    n_k . a_k = -|v_k|^2 / r_k        T_k + mu_k sign_k N_k = 0
    rolling    n_k . a_k = -|v_k|^2 / r_k        t_k . a_k = -R_s Omega'

The equation of N_k in contact is (4.15) divided by 2 r_k, that of T_k in rolling is (4.33). Those of a free site need
no solution, and T_k of a sliding one is put into the other equations: N_k of the sites in contact and T_k of those that
roll are solved for. The same equations, with other right-hand sides, give impulses (`impact`) and corrections
(`project`). Sites whose contact yields (`compliant`) have none.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.interface import (
    CLEARANCE,
    CONSTRAINT,
    ENABLED,
    FREE,
    JOURNAL_RADIUS,
    LAW,
    MU,
    MU_STATIC,
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
IMPULSE = PLANE + 8  # of the impacts in this step (N s)
LOSS, DRIVE = PLANE + 9, PLANE + 10  # heat of these impacts, and the drive's work against their friction (J)
P_N, P_T = PLANE + 11, PLANE + 12  # scratch: impulses
SLOT, MARK, MODE_BEFORE, REBOUND = PLANE + 13, PLANE + 14, PLANE + 15, PLANE + 16  # scratch of equations and events
SITE_COLUMNS = PLANE + 17

RHS = 2 * N_SITES  # the right-hand side is the last column of the equations


@kernel
def held(sites: Array, k: int) -> bool:
    """Whether site k is in contact by constraint."""
    return sites[k, MODE] != FREE and sites[k, LAW] == CONSTRAINT


@kernel
def can_touch(sites: Array, k: int) -> bool:
    """Whether site k is there and free."""
    return sites[k, MODE] == FREE and sites[k, ENABLED] != 0.0


@kernel
def can_strike(sites: Array, k: int) -> bool:
    """Whether site k is there, free and rigid: an impact closes it."""
    return can_touch(sites, k) and sites[k, LAW] == CONSTRAINT


@kernel
def number_unknowns(sites: Array) -> int:
    """Give N, and T of the sites that roll, their place in the equations; returns how many unknowns there are."""
    count = 0
    for k in range(N_SITES):
        if held(sites, k):
            sites[k, SLOT] = count
            count += 2 if sites[k, MODE] == ROLLING else 1
    return count


@kernel
def sticking_friction(sites: Array, k: int) -> float:
    """Coefficient up to which site k sticks."""
    return max(sites[k, MU], sites[k, MU_STATIC])


@kernel
def friction_excess(sites: Array, k: int) -> float:
    """|T| - mu_s N (N) of a rolling site k: positive where it can stick no longer."""
    excess: float = abs(sites[k, TANGENTIAL]) - sticking_friction(sites, k) * sites[k, NORMAL]
    return excess


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
def put_on_circle(sites: Array, k: int, q: Array) -> None:
    """Put the journal of site k on its circle, along its normal (which must be up to date)."""
    row = int(sites[k, PLANE])
    q[row] = sites[k, OFFSET_X] + sites[k, CLEARANCE] * sites[k, N_X]
    q[row + 1] = sites[k, OFFSET_Y] + sites[k, CLEARANCE] * sites[k, N_Y]


@kernel
def stop_radially(sites: Array, k: int, v: Array) -> float:
    """Take the radial velocity from the node of site k alone (4.22); returns what it was (m/s)."""
    row = int(sites[k, PLANE])
    speed: float = radial(sites, k, v)
    v[row] -= speed * sites[k, N_X]
    v[row + 1] -= speed * sites[k, N_Y]
    return speed


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
def write_equations(Minv: Array, sites: Array, equations: Array, friction: float) -> int:
    """Left-hand sides for the held sites in their modes; right-hand sides are zeroed. Returns the number of equations.

    Row and column SLOT belong to N_k, the next to T_k if the site rolls; a column holds the response M^-1 (-n) or
    M^-1 t, that of N_k of a sliding site with its friction, M^-1 (-n - mu sign t). `friction` is 1, or 0 to leave
    sliding friction out.
    """
    size = number_unknowns(sites)
    for k in range(N_SITES):
        if not held(sites, k):
            continue
        i = int(sites[k, PLANE])
        row = int(sites[k, SLOT])
        k_x = sites[k, N_X]
        k_y = sites[k, N_Y]
        rolling = sites[k, MODE] == ROLLING
        equations[row, RHS] = 0.0
        if rolling:
            equations[row + 1, RHS] = 0.0
        for other in range(N_SITES):
            if not held(sites, other):
                continue
            j = int(sites[other, PLANE])
            column = int(sites[other, SLOT])
            n_x = sites[other, N_X]
            n_y = sites[other, N_Y]
            # response at site k, in x and y, to a unit force along n and along t at the other site
            xn = Minv[i, j] * n_x + Minv[i, j + 1] * n_y
            yn = Minv[i + 1, j] * n_x + Minv[i + 1, j + 1] * n_y
            xt = Minv[i, j + 1] * n_x - Minv[i, j] * n_y
            yt = Minv[i + 1, j + 1] * n_x - Minv[i + 1, j] * n_y
            dragged = sliding_share(sites, other, friction)
            equations[row, column] = -(k_x * xn + k_y * yn) + dragged * (k_x * xt + k_y * yt)
            if rolling:
                equations[row + 1, column] = -(k_x * yn - k_y * xn) + dragged * (k_x * yt - k_y * xt)
            if sites[other, MODE] == ROLLING:
                equations[row, column + 1] = k_x * xt + k_y * yt
                if rolling:
                    equations[row + 1, column + 1] = k_x * yt - k_y * xt
    return size


@kernel
def sliding_share(sites: Array, k: int, friction: float) -> float:
    """T_k/N_k of a held site that slides; 0 where it rolls, and T_k is an unknown of its own."""
    if sites[k, MODE] == ROLLING:
        return 0.0
    share: float = -friction * sites[k, MU] * sites[k, SIGN]
    return share


@kernel
def solution(sites: Array, equations: Array, k: int, friction: float) -> tuple[float, float]:
    """N_k and T_k of a held site from the solved equations; `friction` as for `write_equations`."""
    row = int(sites[k, SLOT])
    normal = equations[row, RHS]
    if sites[k, MODE] == ROLLING:
        return normal, equations[row + 1, RHS]
    return normal, sliding_share(sites, k, friction) * normal


@kernel
def solve(equations: Array, n: int, rhs: int) -> bool:
    """Gaussian elimination with partial pivoting of the first `n` equations; the solution replaces column `rhs`.

    False if they are singular.
    """
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if abs(equations[r, i]) > abs(equations[best, i]):
                best = r
        if not abs(equations[best, i]) > 1e-300:
            return False
        if best != i:
            for c in range(i, n):
                equations[i, c], equations[best, c] = equations[best, c], equations[i, c]
            equations[i, rhs], equations[best, rhs] = equations[best, rhs], equations[i, rhs]
        for r in range(i + 1, n):
            ratio = equations[r, i] / equations[i, i]
            if ratio != 0.0:
                for c in range(i + 1, n):
                    equations[r, c] -= ratio * equations[i, c]
                equations[r, rhs] -= ratio * equations[i, rhs]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            equations[i, rhs] -= equations[i, c] * equations[c, rhs]
        equations[i, rhs] /= equations[i, i]
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
def apply_contact(Minv: Array, sites: Array, equations: Array, q: Array, v: Array, Omega_dot: float, a: Array) -> bool:
    """Solve the multipliers of the held sites and add their effect to the acceleration `a`; False if singular."""
    for k in range(N_SITES):
        if held(sites, k):
            locate(sites, k, q)
    size = write_equations(Minv, sites, equations, 1.0)
    if size == 0:
        return True
    for k in range(N_SITES):
        if held(sites, k):
            i = int(sites[k, PLANE])
            row = int(sites[k, SLOT])
            curvature = (v[i] * v[i] + v[i + 1] * v[i + 1]) / sites[k, RADIUS]
            equations[row, RHS] = -curvature - radial(sites, k, a)
            if sites[k, MODE] == ROLLING:
                equations[row + 1, RHS] = -sites[k, JOURNAL_RADIUS] * Omega_dot - tangential(sites, k, a)
    if not solve(equations, size, RHS):
        return False
    for k in range(N_SITES):
        if held(sites, k):
            sites[k, NORMAL], sites[k, TANGENTIAL] = solution(sites, equations, k, 1.0)
            push(Minv, sites, k, sites[k, NORMAL], sites[k, TANGENTIAL], a)
    return True


@kernel
def project(Minv: Array, sites: Array, equations: Array, q: Array, v: Array, Omega: float) -> bool:
    """Put held sites back on the circle and onto the velocity constraint, by the mass-weighted smallest change.

    Without this the drift of the integrated constraint (4.14) grows with time. Friction plays no part in it. One Newton
    step is enough for positions: what a substep leaves is squared.
    """
    for target in range(2):
        for k in range(N_SITES):
            if held(sites, k):
                locate(sites, k, q)
        size = write_equations(Minv, sites, equations, 0.0)
        if size == 0:
            return True
        for k in range(N_SITES):
            if held(sites, k):
                row = int(sites[k, SLOT])
                if target == 0:
                    equations[row, RHS] = sites[k, CLEARANCE] - sites[k, RADIUS]
                else:
                    equations[row, RHS] = -radial(sites, k, v)
                    if sites[k, MODE] == ROLLING:
                        equations[row + 1, RHS] = -slip_velocity(sites, k, v, Omega)
        if not solve(equations, size, RHS):
            return False
        for k in range(N_SITES):
            if held(sites, k):
                normal, forward = solution(sites, equations, k, 0.0)
                push(Minv, sites, k, normal, forward, q if target == 0 else v)
    return True
