"""Impacts: what the velocities become when journals touch their retainers (thesis 4.22, 4.23, and Newton's law)."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.constants import Structure
from rotor_contact.contact import (
    Sites,
    assemble_rows,
    locate,
    push,
    radial,
    read_unknowns,
    slip_velocity,
    solve,
)
from rotor_contact.dynamics import quadratic_form
from rotor_contact.interface import FREE, N_SITES, ROLLING, SLIDING

UNTOUCHED, TOUCHING = 0, 1  # values of Sites.mark


@kernel
def nodal_impact(s: Structure, sites: Sites, v: Array) -> None:
    """The radial velocity of each touching node alone becomes zero (4.22, 4.23); marked sites begin to slide.

    This is the rule of the thesis. It does not conserve momentum: the rest of the rotor is not asked. The impulse
    reported is the momentum that the node's own condensed mass loses.
    """
    before = quadratic_form(s.M, v)
    for k in range(N_SITES):
        if sites.mark[k] == TOUCHING:
            row = int(s.rows[k])
            speed = radial(s, sites, k, v)
            v[row] -= speed * sites.normals[2 * k]
            v[row + 1] -= speed * sites.normals[2 * k + 1]
            sites.impulse[k] += s.M[row, row] * speed
            sites.mode[k] = SLIDING
    sites.loss[0] += 0.5 * (before - quadratic_form(s.M, v))


@kernel
def newton_impact(s: Structure, sites: Sites, v: Array, before: Array, Omega: float) -> bool:
    """Impulses at all touching and closed sites at once; False if no consistent set was found.

    v+ = v- - M^-1 J^T P with n . v+ = -e n . v- at touching sites, n . v+ = 0 at sites already closed, P >= 0 with
    sites that would be pulled left out, and a Coulomb impulse that opposes slip and cannot reverse it.

    Parameters
    ----------
    s, sites
        Structure and sites; `sites.mark` says which touch, `sites.rebound` their e.
    v
        Velocities (m/s), changed in place.
    before
        Scratch of the same shape.
    Omega
        Spin speed (rad/s).

    Notes
    -----
    A combination of restitution and friction that would create energy (possible with several coupled sites) is
    repeated without either. The energy is that of the whole contact: what friction takes from the spin counts.
    """
    before[:] = v
    for k in range(N_SITES):
        if sites.mark[k] == TOUCHING:
            begin_slip(s, sites, k, v, Omega)
    sites.mode_before[:] = sites.mode
    for attempt in range(2):
        plain = attempt == 1
        sites.mode[:] = sites.mode_before
        if not _impulses(s, sites, v, before, Omega, plain):
            continue
        loss = 0.0
        for k in range(N_SITES):
            loss += 0.5 * sites.P_n[k] * (radial(s, sites, k, before) + radial(s, sites, k, v))
            loss -= (
                0.5 * sites.P_t[k] * (slip_velocity(s, sites, k, before, Omega) + slip_velocity(s, sites, k, v, Omega))
            )
        if loss < -1e-12 * (1.0 + quadratic_form(s.M, before)):
            continue
        sites.loss[0] += loss
        for k in range(N_SITES):
            sites.impulse[k] += sites.P_n[k]
            if sites.mark[k] == TOUCHING and radial(s, sites, k, v) < -1e-12:
                sites.mode[k] = FREE
        return True
    return False


@kernel
def begin_slip(s: Structure, sites: Sites, k: int, v: Array, Omega: float) -> None:
    """Close site k in sliding, with friction against the present slip."""
    sites.mode[k] = SLIDING
    sites.sign[k] = 1.0 if slip_velocity(s, sites, k, v, Omega) >= 0.0 else -1.0


@kernel
def _impulses(s: Structure, sites: Sites, v: Array, before: Array, Omega: float, plain: bool) -> bool:
    """One consistent set of impulses P_n, P_t; `plain` leaves restitution and sliding friction out."""
    friction = 0.0 if plain else 1.0
    for _ in range(4 * N_SITES + 2):
        row = 0
        for k in range(N_SITES):
            if sites.mode[k] == FREE:
                continue
            approach = radial(s, sites, k, before)
            rebound = sites.rebound[k] if sites.mark[k] == TOUCHING and not plain else 0.0
            sites.b[row] = -(1.0 + rebound) * approach
            row += 1
            if sites.mode[k] == ROLLING:
                sites.b[row] = -slip_velocity(s, sites, k, before, Omega)
                row += 1
        assemble_rows(s, sites, friction)
        if not solve(sites.A, sites.b, row):
            return False
        read_unknowns(sites, sites.P_n, sites.P_t)
        v[:] = before
        weakest = 0
        for k in range(N_SITES):
            if sites.mode[k] == SLIDING:
                sites.P_t[k] *= friction
            push(s, sites, k, sites.P_n[k], sites.P_t[k], v)
            if sites.P_n[k] < sites.P_n[weakest]:
                weakest = k
        if sites.P_n[weakest] < 0.0:
            sites.mode[weakest] = FREE
            continue
        if plain or not (_adjust_friction(s, sites, v, Omega) or _close_again(s, sites, v, Omega)):
            return True
    return False


@kernel
def _adjust_friction(s: Structure, sites: Sites, v: Array, Omega: float) -> bool:
    """Change one site between slip and stick if its impulse asks for it; True if something changed."""
    for k in range(N_SITES):
        if sites.mode[k] == SLIDING and sites.mu[k] > 0.0:
            if sites.sign[k] * slip_velocity(s, sites, k, v, Omega) < 0.0:
                sites.mode[k] = ROLLING
                return True
        elif sites.mode[k] == ROLLING and abs(sites.P_t[k]) > sites.mu[k] * sites.P_n[k] * (1.0 + 1e-12):
            sites.mode[k] = SLIDING
            sites.sign[k] = -1.0 if sites.P_t[k] > 0.0 else 1.0
            return True
    return False


@kernel
def _close_again(s: Structure, sites: Sites, v: Array, Omega: float) -> bool:
    """Close one site that was left out and approaches all the same, now that others have changed; True if there is."""
    for k in range(N_SITES):
        if sites.mode[k] == FREE and sites.mode_before[k] != FREE and radial(s, sites, k, v) > 1e-9:
            begin_slip(s, sites, k, v, Omega)
            return True
    return False


@kernel
def mark_touching(s: Structure, sites: Sites, q: Array, v: Array) -> bool:
    """Mark free sites that have reached their retainer and move outward; True if there is one."""
    found = False
    for k in range(N_SITES):
        sites.mark[k] = UNTOUCHED
        sites.rebound[k] = sites.restitution[k]
        r = locate(s, sites, k, q)
        if sites.mode[k] == FREE and r >= sites.clearance[k] * (1.0 - 1e-10) and radial(s, sites, k, v) > 0.0:
            sites.mark[k] = TOUCHING
            found = True
    return found
