"""Impacts: what the velocities become when journals touch their retainers (thesis 4.22, 4.23, and Newton's law)."""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import (
    DRIVE,
    IMPULSE,
    LOSS,
    MARK,
    MODE,
    MODE_BEFORE,
    P_N,
    P_T,
    PLANE,
    REBOUND,
    RHS,
    SIGN,
    SLOT,
    can_strike,
    held,
    locate,
    push,
    put_on_circle,
    radial,
    slip_velocity,
    solution,
    solve,
    sticking_friction,
    stop_radially,
    write_equations,
)
from rotor_contact.dynamics import quadratic_form
from rotor_contact.interface import (
    CLEARANCE,
    FREE,
    JOURNAL_RADIUS,
    MU,
    N_SITES,
    RESTITUTION,
    ROLLING,
    SLIDING,
)

UNTOUCHED, TOUCHING = 0, 1  # values of the column MARK


@kernel
def mark_touching(sites: Array, q: Array, v: Array) -> bool:
    """Mark free sites that have reached their retainer and move outward, and put them on it; True if there is one."""
    found = False
    for k in range(N_SITES):
        sites[k, MARK] = UNTOUCHED
        sites[k, REBOUND] = sites[k, RESTITUTION]
        c = sites[k, CLEARANCE]
        r = locate(sites, k, q)
        reached = can_strike(sites, k) and r >= c * (1.0 - 1e-10)
        outward = radial(sites, k, v) > 0.0
        if reached and (outward or r > c):
            # exactly on the circle, or a site that leaves again would look as if it touched
            put_on_circle(sites, k, q)
            if outward:
                sites[k, MARK] = TOUCHING
                found = True
    return found


@kernel
def begin_slip(sites: Array, k: int, v: Array, Omega: float) -> None:
    """Close site k in sliding, with friction against the present slip."""
    sites[k, MODE] = SLIDING
    sites[k, SIGN] = 1.0 if slip_velocity(sites, k, v, Omega) >= 0.0 else -1.0


@kernel
def break_loose(sites: Array, k: int, held: float) -> None:
    """Let site k, which friction `held` (forward positive), slide: friction keeps its direction."""
    sites[k, MODE] = SLIDING
    sites[k, SIGN] = -1.0 if held > 0.0 else 1.0


@kernel
def nodal_impact(M: Array, sites: Array, v: Array, Omega: float) -> None:
    """The radial velocity of each touching node alone becomes zero (4.22, 4.23), and it begins to slide.

    This is the rule of the thesis. It does not conserve momentum: the rest of the rotor is not asked. The impulse
    reported is the momentum that the node's own condensed mass loses.
    """
    for k in range(N_SITES):
        if sites[k, MARK] == TOUCHING:
            begin_slip(sites, k, v, Omega)
            before = quadratic_form(M, v)
            row = int(sites[k, PLANE])
            speed = stop_radially(sites, k, v)
            sites[k, IMPULSE] += M[row, row] * speed
            sites[k, LOSS] += 0.5 * (before - quadratic_form(M, v))


@kernel
def newton_impact(M: Array, Minv: Array, sites: Array, equations: Array, v: Array, before: Array, Omega: float) -> bool:
    """Impulses at all touching and closed sites at once; False if no consistent set was found.

    v+ = v- - M^-1 J^T P with n . v+ = -e n . v- at touching sites, n . v+ = 0 at sites already closed, P >= 0 with
    sites that would be pulled left out, and a Coulomb impulse that opposes slip and cannot reverse it.

    Parameters
    ----------
    M, Minv
        Mass matrix and its inverse, shape (n, n).
    sites, equations
        Table of sites, whose MARK says which touch and REBOUND with which e; scratch for the equations.
    v, before
        Velocities (m/s), changed in place, and scratch of the same shape.
    Omega
        Spin speed (rad/s).

    Notes
    -----
    A combination of restitution and friction that would create energy (possible with several coupled sites) is
    repeated without either. The energy is that of the whole contact: what friction takes from the spin counts.
    """
    copy(v, before)
    for k in range(N_SITES):
        if sites[k, MARK] == TOUCHING:
            begin_slip(sites, k, v, Omega)
        sites[k, MODE_BEFORE] = sites[k, MODE]
    for attempt in range(2):
        plain = attempt == 1
        for k in range(N_SITES):
            sites[k, MODE] = sites[k, MODE_BEFORE]
        if not _impulses(Minv, sites, equations, v, before, Omega, plain):
            continue
        total = 0.0
        for k in range(N_SITES):
            total += _heat(sites, k, v, before, Omega)
        if total < -1e-12 * (1.0 + quadratic_form(M, before)):
            continue
        for k in range(N_SITES):
            sites[k, LOSS] += _heat(sites, k, v, before, Omega)
            sites[k, DRIVE] -= sites[k, P_T] * sites[k, JOURNAL_RADIUS] * Omega
            sites[k, IMPULSE] += sites[k, P_N]
            if sites[k, MARK] == TOUCHING and radial(sites, k, v) < -1e-12:
                sites[k, MODE] = FREE
        return True
    return False


@kernel
def _heat(sites: Array, k: int, v: Array, before: Array, Omega: float) -> float:
    """Energy (J) that the impulses of site k turn into heat: the mean of the velocities before and after counts."""
    approach = 0.5 * (radial(sites, k, before) + radial(sites, k, v))
    slip = 0.5 * (slip_velocity(sites, k, before, Omega) + slip_velocity(sites, k, v, Omega))
    heat: float = sites[k, P_N] * approach - sites[k, P_T] * slip
    return heat


@kernel
def _impulses(Minv: Array, sites: Array, equations: Array, v: Array, before: Array, Omega: float, plain: bool) -> bool:
    """One consistent set of impulses P_N, P_T; `plain` leaves restitution and sliding friction out."""
    for _ in range(4 * N_SITES + 2):
        friction = 0.0 if plain else 1.0
        size = write_equations(Minv, sites, equations, friction)
        for k in range(N_SITES):
            if held(sites, k):
                row = int(sites[k, SLOT])
                rebound = sites[k, REBOUND] if sites[k, MARK] == TOUCHING and not plain else 0.0
                equations[row, RHS] = -(1.0 + rebound) * radial(sites, k, before)
                if sites[k, MODE] == ROLLING:
                    equations[row + 1, RHS] = -slip_velocity(sites, k, before, Omega)
        if not solve(equations, size, RHS):
            return False
        copy(before, v)
        weakest = 0
        for k in range(N_SITES):
            sites[k, P_N] = 0.0
            sites[k, P_T] = 0.0
            if held(sites, k):
                sites[k, P_N], sites[k, P_T] = solution(sites, equations, k, friction)
                push(Minv, sites, k, sites[k, P_N], sites[k, P_T], v)
            if sites[k, P_N] < sites[weakest, P_N]:
                weakest = k
        if sites[weakest, P_N] < 0.0:
            sites[weakest, MODE] = FREE
            continue
        if plain or not (_adjust_friction(sites, v, Omega) or _close_again(sites, v, Omega)):
            return True
    return False


@kernel
def _adjust_friction(sites: Array, v: Array, Omega: float) -> bool:
    """Change one site between slip and stick if its impulse asks for it; True if something changed."""
    for k in range(N_SITES):
        if not held(sites, k):
            continue
        limit = sticking_friction(sites, k) * sites[k, P_N]
        if sites[k, MODE] == ROLLING and abs(sites[k, P_T]) > limit * (1.0 + 1e-12):
            break_loose(sites, k, sites[k, P_T])
            return True
        if (
            sites[k, MODE] == SLIDING
            and sites[k, MU] > 0.0
            and sites[k, SIGN] * slip_velocity(sites, k, v, Omega) < 0.0
        ):
            sites[k, MODE] = ROLLING
            return True
    return False


@kernel
def _close_again(sites: Array, v: Array, Omega: float) -> bool:
    """Close one site that was left out and approaches all the same, now that others have changed; True if there is."""
    for k in range(N_SITES):
        if sites[k, MODE] == FREE and sites[k, MODE_BEFORE] != FREE and radial(sites, k, v) > 1e-9:
            begin_slip(sites, k, v, Omega)
            return True
    return False
