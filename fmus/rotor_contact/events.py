"""Motion through located contact events.

Between events the motion is smooth. Each kind of event is the rising zero crossing of an indicator:

    free       gap closes             |r| - c
    held       normal force vanishes  -N
    yielding   gap opens              c - |r|
    sliding    slip vanishes          -sign v_slip
    rolling    friction too small     |T| - mu_s N

The crossing is located by repeating the substep with another length, so events are not rounded to steps; then modes and
velocities change, and integration goes on from there.
"""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import (
    MARK,
    MODE,
    NORMAL,
    REBOUND,
    SIGN,
    TANGENTIAL,
    can_strike,
    can_touch,
    friction_excess,
    held,
    locate,
    project,
    radial,
    slip_velocity,
    tangential,
)
from rotor_contact.dynamics import Motion, spin
from rotor_contact.impact import begin_slip, break_loose, mark_touching, newton_impact, nodal_impact
from rotor_contact.integration import (
    BEFORE,
    K_1,
    K_NEW,
    TALLIES,
    Z_NEW,
    Z,
    derivative,
    substep,
    substep_limit,
    velocity_error,
)
from rotor_contact.interface import CLEARANCE, CONSTRAINT, ENABLED, FREE, LAW, MU, N_SITES, NODAL, ROLLING, SLIDING
from rotor_contact.path import stays_within, touches_at

FAULT_TOO_MANY_EVENTS, FAULT_SINGULAR = 1, 2

CROWDED = 50  # events of one step, then impacts no longer rebound and flights shorter than a substep are not resolved
SHORTEST_CROWDED = 1.0 / 200.0  # of a step, then no event is located closer to the one before: this bounds their number
CARELESS = 1e-2  # of the clearance, how far a journal may get beyond its retainer for that
SHORTEST_FLIGHT = 1e-3  # of a substep; a shorter one is sustained contact
FORCE_SCALE = 1e3  # N, and m/s for velocities: makes indicators comparable
TOLERANCE = 1e-12  # of the indicators, below which nothing has happened
AIM = 1e-11  # value of the indicator at a located event
STICTION = 1e-9  # m/s, slip that counts as none
MOST_CORRECTIONS = 4  # of a located touch
MOST_HALVINGS = 2.0  # of a substep for the sake of accuracy
SMALL = 0.03  # of the tolerance: a substep of twice the length would meet it too, since the estimate is of fourth order


@kernel
def indicator(sites: Array, z: Array, Omega: float) -> float:
    """Largest of all sites' event indicators at z (contact forces must be up to date); positive after an event."""
    n = (z.shape[0] - TALLIES) // 2
    largest = -1.0
    for k in range(N_SITES):
        if sites[k, ENABLED] == 0.0:
            continue
        if not held(sites, k):
            beyond = locate(sites, k, z[:n]) / sites[k, CLEARANCE] - 1.0
            largest = max(largest, beyond if sites[k, MODE] == FREE else -beyond)
            continue
        largest = max(largest, -sites[k, NORMAL] / FORCE_SCALE)
        if sites[k, MODE] == ROLLING:
            largest = max(largest, friction_excess(sites, k) / FORCE_SCALE)
        elif sites[k, MU] > 0.0:
            largest = max(largest, -sites[k, SIGN] * slip_velocity(sites, k, z[n : 2 * n], Omega))
    return largest


@kernel
def deepest(sites: Array, q: Array) -> float:
    """How far the free journals are beyond their rigid retainers, the largest over its clearance."""
    largest = 0.0
    for k in range(N_SITES):
        if can_strike(sites, k):
            largest = max(largest, locate(sites, k, q) / sites[k, CLEARANCE] - 1.0)
    return largest


@kernel
def locate_touch(Minv: Array, m: Motion, sites: Array, equations: Array, r: Array, tau: float, dt: float) -> float:
    """Length of the substep that ends on the first touch of a free site, z_new left there; 0 if that is not the event.

    The cubic path gives the time, Newton's method on the radius corrects it by the little that it errs.
    """
    n = Minv.shape[0]
    first = -1
    trial = dt
    for k in range(N_SITES):
        if can_touch(sites, k) and locate(sites, k, r[Z_NEW, :n]) > sites[k, CLEARANCE]:
            when = touches_at(sites, k, r[Z], r[Z_NEW], dt, n)
            if first < 0 or when < trial:
                first, trial = k, when
    if first < 0:
        return 0.0
    for _ in range(MOST_CORRECTIONS):
        substep(Minv, m, sites, equations, r, tau, trial)
        f = indicator(sites, r[Z_NEW], spin(m, tau + trial)) - AIM
        if abs(f) < AIM - TOLERANCE:
            return trial
        beyond = locate(sites, first, r[Z_NEW, :n]) / sites[first, CLEARANCE] - 1.0 - AIM
        outward = radial(sites, first, r[Z_NEW, n : 2 * n])
        if not outward > 0.0:
            break
        trial -= beyond * sites[first, CLEARANCE] / outward
        if not 0.0 < trial <= dt:
            break
    return 0.0


@kernel
def locate_event(Minv: Array, m: Motion, sites: Array, equations: Array, r: Array, tau: float, dt: float) -> float:
    """Length in (0, dt] of the substep that ends on the first event found; z_new is left there.

    Regula falsi with the Illinois modification for indicator = AIM, so that the event is just past; bisection while the
    left end lies on the event itself (a site that has just opened starts on the circle).
    """
    low = 0.0
    high = dt
    f_low = -AIM
    f_high = indicator(sites, r[Z_NEW], spin(m, tau + dt)) - AIM
    side = 0
    located = locate_touch(Minv, m, sites, equations, r, tau, dt)
    if located > 0.0:
        return located
    for _ in range(100):
        if high - low <= 1e-15 * dt:
            break
        trial = 0.5 * (low + high)
        if f_low < -1e-6 * f_high:
            trial = low + (high - low) * f_low / (f_low - f_high)
        substep(Minv, m, sites, equations, r, tau, trial)
        f = indicator(sites, r[Z_NEW], spin(m, tau + trial)) - AIM
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
    substep(Minv, m, sites, equations, r, tau, high)
    return high


@kernel
def may_touch_between(sites: Array, r: Array, dt: float) -> bool:
    """Whether the path of a free site from z to z_new may pass its retainer."""
    n = (r.shape[1] - TALLIES) // 2
    for k in range(N_SITES):
        if can_touch(sites, k) and not stays_within(sites, k, r[Z], r[Z_NEW], dt, n, 0.0):
            return True
    return False


@kernel
def settle(Minv: Array, m: Motion, sites: Array, equations: Array, r: Array, tau: float, shortest: float) -> bool:
    """Modes that are consistent with the forces at z: no pull, no friction beyond Coulomb's; leaves k1.

    Sites that would touch again within `shortest` (s) count as closed: that is where the bouncing of one site, or of
    two in turn, accumulates.
    """
    n = Minv.shape[0]
    q = r[Z, :n]
    v = r[Z, n : 2 * n]
    Omega = spin(m, tau)
    for k in range(N_SITES):
        sites[k, MARK] = 0.0
        if sites[k, ENABLED] != 0.0 and sites[k, LAW] != CONSTRAINT:
            sites[k, MODE] = SLIDING if locate(sites, k, q) > sites[k, CLEARANCE] else FREE
    for _ in range(6 * N_SITES + 1):
        project(Minv, sites, equations, q, v, Omega)
        if not derivative(Minv, m, sites, equations, tau, r[Z], r[K_1]):
            return False
        if not (
            _release_one(sites)
            or _change_friction(sites, v, Omega)
            or _close_one(sites, q, v, r[K_1, n : 2 * n], Omega, shortest)
        ):
            return True
    return True


@kernel
def _release_one(sites: Array) -> bool:
    """Open the closed site that pulls most; True if there is one."""
    weakest = -1
    force = -TOLERANCE * FORCE_SCALE
    for k in range(N_SITES):
        if held(sites, k) and sites[k, NORMAL] < force:
            weakest = k
            force = sites[k, NORMAL]
    if weakest < 0:
        return False
    sites[weakest, MODE] = FREE
    sites[weakest, MARK] = 1.0
    return True


@kernel
def _close_one(sites: Array, q: Array, v: Array, a: Array, Omega: float, shortest: float) -> bool:
    """Close a free site on its circle whose next flight takes less than `shortest`; True if there is one."""
    for k in range(N_SITES):
        if can_strike(sites, k) and sites[k, MARK] == 0.0:
            radius = locate(sites, k, q)
            if radius >= sites[k, CLEARANCE] * (1.0 - 1e-10):
                outward = radial(sites, k, a) + tangential(sites, k, v) ** 2 / radius
                if outward > 0.0 and -2.0 * radial(sites, k, v) < shortest * outward:
                    begin_slip(sites, k, v, Omega)
                    sites[k, MARK] = 1.0
                    return True
    return False


@kernel
def _change_friction(sites: Array, v: Array, Omega: float) -> bool:
    """Let one site stick that has stopped slipping, or slip that cannot stick; True if something changed.

    Of several that cannot stick the one furthest beyond its limit slips first: another may roll on once it does. An
    impact elsewhere may have reversed the slip of a sliding site: friction turns with it.
    """
    loosest = -1
    excess = 0.0
    for k in range(N_SITES):
        if held(sites, k) and sites[k, MODE] == ROLLING:
            beyond = friction_excess(sites, k)
            if beyond > excess:
                loosest = k
                excess = beyond
    if loosest >= 0:
        break_loose(sites, loosest, sites[loosest, TANGENTIAL])
        sites[loosest, MARK] = 1.0  # it slips for good; do not try to stick again at this instant
        return True
    for k in range(N_SITES):
        if held(sites, k) and sites[k, MODE] == SLIDING and sites[k, MU] > 0.0:
            slip = slip_velocity(sites, k, v, Omega)
            if abs(slip) <= STICTION:
                if sites[k, MARK] == 0.0:
                    sites[k, MODE] = ROLLING
                    return True
            elif sites[k, SIGN] * slip < 0.0:
                sites[k, SIGN] = -sites[k, SIGN]
                return True
    return False


@kernel
def strike(
    M: Array, Minv: Array, sites: Array, equations: Array, r: Array, Omega: float, law: int, crowded: bool
) -> bool:
    """Apply the impact law where free sites have reached their retainers; False if no impulse was found."""
    n = M.shape[0]
    v = r[Z, n : 2 * n]
    if not mark_touching(sites, r[Z, :n], v):
        return True
    if law == NODAL:
        nodal_impact(M, sites, v, Omega)
        return True
    if crowded:
        sites[:, REBOUND] = 0.0
    return newton_impact(M, Minv, sites, equations, v, r[BEFORE, :n], Omega)


@kernel
def advance(
    M: Array,
    Minv: Array,
    m: Motion,
    sites: Array,
    equations: Array,
    r: Array,
    law: int,
    step_size: float,
    max_substep: float,
    tolerance: float,
    pace: Array,
) -> int:
    """Advance z over one communication step of `step_size` (s); returns a fault code.

    Substeps are no longer than `max_substep`, nor than fast whirl allows, and end on events. They are halved, up to
    `MOST_HALVINGS` times, where their velocities err by more than `tolerance` (m/s); how often, `pace` (one number)
    remembers for the next.
    """
    n = M.shape[0]
    substeps = int(step_size / max_substep + 1.0 - 1e-9)
    longest = step_size / substeps
    shortest = SHORTEST_FLIGHT * longest
    tau = 0.0
    events = 0
    if not settle(Minv, m, sites, equations, r, tau, shortest):
        return FAULT_SINGULAR
    while tau < step_size * (1.0 - 1e-12):
        limit = substep_limit(Minv, sites, r[Z, n : 2 * n], spin(m, tau), longest)
        while True:
            dt = min(step_size - tau, limit, longest * 0.5 ** pace[0])
            if not substep(Minv, m, sites, equations, r, tau, dt):
                return FAULT_SINGULAR
            event = indicator(sites, r[Z_NEW], spin(m, tau + dt)) > TOLERANCE
            error = velocity_error(r, dt)
            if pace[0] >= MOST_HALVINGS or (error <= tolerance and (event or not may_touch_between(sites, r, dt))):
                break
            pace[0] += 1.0
        if error < SMALL * tolerance and pace[0] > 0.0:
            pace[0] -= 1.0
        crowded = events > CROWDED
        if event:
            dt = locate_event(Minv, m, sites, equations, r, tau, dt)
            # strong friction can leave no consistent motion: time must go on all the same
            if crowded and dt < SHORTEST_CROWDED * step_size:
                dt = min(SHORTEST_CROWDED * step_size, step_size - tau)
                substep(Minv, m, sites, equations, r, tau, dt)
                if deepest(sites, r[Z_NEW, :n]) > CARELESS:
                    return FAULT_TOO_MANY_EVENTS
        tau += dt
        copy(r[Z_NEW], r[Z])
        copy(r[K_NEW], r[K_1])
        if event:
            events += 1
            if not strike(M, Minv, sites, equations, r, spin(m, tau), law, crowded):
                return FAULT_SINGULAR
            if not settle(Minv, m, sites, equations, r, tau, longest if crowded else shortest):
                return FAULT_SINGULAR
    return 0
