"""Time integration with located contact events.

Between events the motion is smooth and integrated by the classical fourth-order Runge-Kutta method. Each kind of event
is the rising zero crossing of an indicator:

    free       gap closes             |r| - c
    closed     normal force vanishes  -N
    sliding    slip vanishes          -sign v_slip
    rolling    friction too small     |T| - mu N

The crossing is located by repeating the substep with another length, so events are not rounded to steps; then modes
and velocities change, and integration goes on from there.
"""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.constants import Structure
from rotor_contact.contact import Sites, apply_contact, locate, project, radial, slip_velocity, tangential
from rotor_contact.dynamics import Motion, free_acceleration
from rotor_contact.impact import TOUCHING, begin_slip, mark_touching, newton_impact, nodal_impact
from rotor_contact.interface import (
    BEARING,
    BEARING_PARAMETERS,
    DAMPING,
    FREE,
    N_BEARINGS,
    N_SITES,
    NODAL,
    ROLLING,
    SLIDING,
)

FAULT_TOO_MANY_EVENTS, FAULT_SINGULAR = 1, 2

MAX_EVENTS = 500  # of one step; a bouncing site ends in contact long before
PLASTIC_AFTER = 50  # events, then impacts no longer rebound and flights shorter than a substep are not resolved
SHORTEST_FLIGHT = 1e-3  # of a substep; a shorter one is sustained contact
SHORTEST_TURN = 0.01  # of a substep; no shorter ones however fast the whirl
FORCE_SCALE = 1e3  # N, and m/s for velocities: makes indicators comparable
TOLERANCE = 1e-12  # of the indicators, below which nothing has happened
AIM = 1e-11  # value of the indicator at a located event
STICTION = 1e-9  # m/s, slip that counts as none
MAX_TURN = 0.1  # rad that a closed site may whirl in a substep; rolling is fast, and the constraint turns with it


class Run(NamedTuple):
    """Integration state and scratch: z = (q, v, heat), shape (2 n + 1,), and the arrays of one Runge-Kutta step.

    z, z_new, z_stage
        State at the beginning and end of a substep, and at a stage.
    k1, k2, k3, k4, k_new
        Derivatives; k1 belongs to z and k_new to z_new.
    before
        Scratch for impacts, shape (n,).
    """

    z: Array
    z_new: Array
    z_stage: Array
    k1: Array
    k2: Array
    k3: Array
    k4: Array
    k_new: Array
    before: Array


@kernel
def derivative(s: Structure, m: Motion, sites: Sites, parameters: Array, tau: float, z: Array, dz: Array) -> bool:
    """d/dt (q, v, heat) with contact; heat is the power of passive bearing damping and friction (W)."""
    n = s.M.shape[0]
    q = z[:n]
    v = z[n : 2 * n]
    dz[:n] = v
    free_acceleration(m, tau, q, v, dz[n : 2 * n])
    solved = apply_contact(s, sites, q, v, dz[n : 2 * n])
    heat = 0.0
    for k in range(N_BEARINGS):
        row = int(s.rows[k])
        c_b = parameters[BEARING + k * BEARING_PARAMETERS + DAMPING]
        heat += c_b * (v[row] * v[row] + v[row + 1] * v[row + 1])
    for k in range(N_SITES):
        if sites.mode[k] == SLIDING:
            heat -= sites.tangential[k] * slip_velocity(s, sites, k, v, m.Omega)
    dz[2 * n] = heat
    return solved


@kernel
def substep(s: Structure, m: Motion, sites: Sites, parameters: Array, r: Run, tau: float, dt: float) -> bool:
    """One Runge-Kutta step from z to z_new, projected onto the constraints; also leaves the derivative in k_new."""
    size = r.z.shape[0]
    n = s.M.shape[0]
    for i in range(size):
        r.z_stage[i] = r.z[i] + 0.5 * dt * r.k1[i]
    solved = derivative(s, m, sites, parameters, tau + 0.5 * dt, r.z_stage, r.k2)
    for i in range(size):
        r.z_stage[i] = r.z[i] + 0.5 * dt * r.k2[i]
    solved = derivative(s, m, sites, parameters, tau + 0.5 * dt, r.z_stage, r.k3) and solved
    for i in range(size):
        r.z_stage[i] = r.z[i] + dt * r.k3[i]
    solved = derivative(s, m, sites, parameters, tau + dt, r.z_stage, r.k4) and solved
    for i in range(size):
        r.z_new[i] = r.z[i] + dt / 6.0 * (r.k1[i] + 2.0 * (r.k2[i] + r.k3[i]) + r.k4[i])
    solved = project(s, sites, r.z_new[:n], r.z_new[n : 2 * n], m.Omega) and solved
    return derivative(s, m, sites, parameters, tau + dt, r.z_new, r.k_new) and solved


@kernel
def indicator(s: Structure, m: Motion, sites: Sites, z: Array) -> float:
    """Largest of all sites' event indicators at z (contact forces must be up to date); positive after an event."""
    n = s.M.shape[0]
    largest = -1.0
    for k in range(N_SITES):
        if sites.mode[k] == FREE:
            c = sites.clearance[k]
            largest = max(largest, (locate(s, sites, k, z[:n]) - c) / c)
            continue
        largest = max(largest, -sites.normal[k] / FORCE_SCALE)
        if sites.mode[k] == ROLLING:
            friction = abs(sites.tangential[k]) - sites.mu[k] * sites.normal[k]
            largest = max(largest, friction / FORCE_SCALE)
        elif sites.mu[k] > 0.0:
            largest = max(largest, -sites.sign[k] * slip_velocity(s, sites, k, z[n : 2 * n], m.Omega))
    return largest


@kernel
def locate_event(s: Structure, m: Motion, sites: Sites, parameters: Array, r: Run, tau: float, dt: float) -> float:
    """Length in (0, dt] of the substep that ends on the first event found; z_new is left there.

    Regula falsi with the Illinois modification for indicator = AIM, so that the event is just past; bisection while the
    left end lies on the event itself (a site that has just opened starts on the circle).
    """
    low = 0.0
    high = dt
    f_low = -AIM
    f_high = indicator(s, m, sites, r.z_new) - AIM
    side = 0
    for _ in range(100):
        if high - low <= 1e-15 * dt:
            break
        trial = 0.5 * (low + high)
        if f_low < -1e-6 * f_high:
            trial = low + (high - low) * f_low / (f_low - f_high)
        substep(s, m, sites, parameters, r, tau, trial)
        f = indicator(s, m, sites, r.z_new) - AIM
        if abs(f) < AIM - TOLERANCE:
            return trial
        if f > 0.0:
            high = trial
            f_high = f
            if side == 1:
                f_low *= 0.5
            side = 1
        else:
            low = trial
            f_low = f
            if side == -1:
                f_high *= 0.5
            side = -1
    substep(s, m, sites, parameters, r, tau, high)
    return high


@kernel
def settle(s: Structure, m: Motion, sites: Sites, parameters: Array, tau: float, r: Run, shortest: float) -> bool:
    """Modes that are consistent with the forces at z: no pull, no friction beyond Coulomb's; leaves k1.

    Sites that would touch again within `shortest` (s) count as closed: that is where the bouncing of one site, or of
    two in turn, accumulates.
    """
    n = s.M.shape[0]
    q = r.z[:n]
    v = r.z[n : 2 * n]
    for k in range(N_SITES):
        sites.mark[k] = 0.0
    for _ in range(6 * N_SITES + 1):
        project(s, sites, q, v, m.Omega)
        if not derivative(s, m, sites, parameters, tau, r.z, r.k1):
            return False
        if not (
            _release_one(sites)
            or _change_friction(s, m, sites, v)
            or _close_one(s, m, sites, q, v, r.k1[n : 2 * n], shortest)
        ):
            return True
    return True


@kernel
def _release_one(sites: Sites) -> bool:
    """Open the closed site that pulls most; True if there is one."""
    weakest = -1
    force = -TOLERANCE * FORCE_SCALE
    for k in range(N_SITES):
        if sites.mode[k] != FREE and sites.normal[k] < force:
            weakest = k
            force = sites.normal[k]
    if weakest < 0:
        return False
    sites.mode[weakest] = FREE
    sites.mark[weakest] = 1.0
    return True


@kernel
def _close_one(s: Structure, m: Motion, sites: Sites, q: Array, v: Array, a: Array, shortest: float) -> bool:
    """Close a free site on its circle whose next flight takes less than `shortest`; True if there is one."""
    for k in range(N_SITES):
        if sites.mode[k] == FREE and sites.mark[k] == 0.0:
            radius = locate(s, sites, k, q)
            if radius >= sites.clearance[k] * (1.0 - 1e-10):
                outward = radial(s, sites, k, a) + tangential(s, sites, k, v) ** 2 / radius
                if outward > 0.0 and -2.0 * radial(s, sites, k, v) < shortest * outward:
                    begin_slip(s, sites, k, v, m.Omega)
                    sites.mark[k] = 1.0
                    return True
    return False


@kernel
def _change_friction(s: Structure, m: Motion, sites: Sites, v: Array) -> bool:
    """Let one site stick that has stopped slipping, or slip that cannot stick; True if something changed.

    An impact elsewhere may have reversed the slip of a sliding site: friction turns with it.
    """
    for k in range(N_SITES):
        if sites.mode[k] == ROLLING and abs(sites.tangential[k]) > sites.mu[k] * sites.normal[k]:
            sites.mode[k] = SLIDING
            sites.sign[k] = -1.0 if sites.tangential[k] > 0.0 else 1.0
            sites.mark[k] = 1.0  # it slips for good; do not try to stick again at this instant
            return True
        if sites.mode[k] == SLIDING and sites.mu[k] > 0.0:
            slip = slip_velocity(s, sites, k, v, m.Omega)
            if abs(slip) <= STICTION:
                if sites.mark[k] == 0.0:
                    sites.mode[k] = ROLLING
                    return True
            elif sites.sign[k] * slip < 0.0:
                sites.sign[k] = -sites.sign[k]
                return True
    return False


@kernel
def strike(s: Structure, m: Motion, sites: Sites, r: Run, law: int, plastic: bool) -> bool:
    """Apply the impact law where free sites have reached their retainers; False if no impulse was found."""
    n = s.M.shape[0]
    q = r.z[:n]
    v = r.z[n : 2 * n]
    if not mark_touching(s, sites, q, v):
        return True
    for k in range(N_SITES):  # a site that leaves again must not look as if it touched
        if sites.mark[k] == TOUCHING:
            row = int(s.rows[k])
            q[row] = sites.offset_x[k] + sites.clearance[k] * sites.normals[2 * k]
            q[row + 1] = sites.offset_y[k] + sites.clearance[k] * sites.normals[2 * k + 1]
    if law == NODAL:
        for k in range(N_SITES):
            if sites.mark[k] == TOUCHING:
                begin_slip(s, sites, k, v, m.Omega)
        nodal_impact(s, sites, v)
        return True
    if plastic:
        sites.rebound[:] = 0.0
    return newton_impact(s, sites, v, r.before, m.Omega)


@kernel
def fastest_whirl(s: Structure, sites: Sites, v: Array) -> float:
    """Largest whirl speed (rad/s) of the closed sites, never zero."""
    fastest = 1e-300
    for k in range(N_SITES):
        if sites.mode[k] != FREE:
            fastest = max(fastest, abs(tangential(s, sites, k, v)) / sites.clearance[k])
    return fastest


@kernel
def advance(
    s: Structure,
    m: Motion,
    sites: Sites,
    parameters: Array,
    r: Run,
    law: int,
    step_size: float,
    max_substep: float,
) -> int:
    """Advance z over one communication step, in substeps within `max_substep` and `MAX_TURN`; returns a fault code."""
    n = s.M.shape[0]
    substeps = int(step_size / max_substep + 1.0 - 1e-9)
    longest = step_size / substeps
    shortest = SHORTEST_FLIGHT * longest
    tau = 0.0
    events = 0
    if not settle(s, m, sites, parameters, tau, r, shortest):
        return FAULT_SINGULAR
    while tau < step_size * (1.0 - 1e-12):
        turn = max(MAX_TURN / fastest_whirl(s, sites, r.z[n : 2 * n]), SHORTEST_TURN * longest)
        dt = min(longest, step_size - tau, turn)
        if not substep(s, m, sites, parameters, r, tau, dt):
            return FAULT_SINGULAR
        event = indicator(s, m, sites, r.z_new) > TOLERANCE
        crowded = events > PLASTIC_AFTER
        if event:
            dt = locate_event(s, m, sites, parameters, r, tau, dt)
            # strong friction can leave no consistent motion: time must go on all the same
            if crowded and dt < shortest:
                dt = min(shortest, step_size - tau)
                substep(s, m, sites, parameters, r, tau, dt)
        tau += dt
        r.z[:] = r.z_new
        r.k1[:] = r.k_new
        if event:
            events += 1
            if events > MAX_EVENTS:
                return FAULT_TOO_MANY_EVENTS
            if not strike(s, m, sites, r, law, crowded):
                return FAULT_SINGULAR
            if not settle(s, m, sites, parameters, tau, r, longest if crowded else shortest):
                return FAULT_SINGULAR
    return 0
