"""Motion through located contact events.

Between events the motion is smooth. An event is a rising zero crossing of an indicator:

    free         gap closes             |r| - c
    constrained  normal force vanishes  -N
    compliant    gap opens              c - |r|
                 pull begins or ends    -sign F of the law's factor F that changes sign
    sliding      slip vanishes          -sign v_slip
    rolling      friction too small     |T| - mu_s N

The crossing is located by repeating the substep with another length, so events are not rounded to steps. Then modes and
velocities change, and integration continues.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.compliant import reversed_push
from rotor_contact.enumerations import FREE, NODAL, ROLLING
from rotor_contact.friction import friction_excess, has_friction, reversed_slip
from rotor_contact.impact import mark_touching, newton_impact, nodal_impact
from rotor_contact.integration import (
    collect_last_substep,
    derivative,
    spin_speed,
    substep,
    substep_limit,
    velocity_error,
)
from rotor_contact.modes import FAULT_SINGULAR, resolve_modes
from rotor_contact.path import leaves_or_stays_within, point_of, stays_within, touch_time
from rotor_contact.site import (
    Sites,
    can_impact,
    can_touch,
    is_constrained,
    locate_journal,
    radial_component,
    slip_velocity,
)
from rotor_contact.workspace import Workspace, stages_of

FAULT_TOO_MANY_EVENTS, FAULT_TOO_STIFF = 1, 8

MAX_SUBSTEPS = 1e5  # of a communication step

EVENT_LIMIT = 50  # events of a step; beyond it impacts do not rebound and flights shorter than a substep are skipped
MIN_EVENT_DISTANCE = 1.0 / 200.0  # of a step, between two events beyond that limit: this bounds their number
MAX_PENETRATION = 1e-2  # of the clearance, that a journal may pass its retainer because of that
SHORTEST_FLIGHT = 1e-3  # of a substep; a shorter flight is sustained contact
FORCE_SCALE = 1e3  # N that count as much as 1 m/s of slip or a clearance: makes indicators comparable
TOLERANCE = 1e-12  # of the indicators, below which nothing has happened
EVENT_OFFSET = 1e-11  # value of the indicator at a located event
MAX_NEWTON_STEPS = 4  # for the time of a touch
MAX_HALVINGS = 2.0  # of a substep for the sake of accuracy
GROW_RATIO = 0.03  # of the tolerance: a substep of twice the length would meet it too, the estimate is of fourth order


@kernel
def indicator(sites: Sites, z: Array, n: int, Omega: float) -> float:
    """Return the largest of all sites' event indicators at z (forces must be up to date); positive after an event."""
    largest = -1.0
    for site in sites:
        if site.enabled == 0.0:
            continue
        if not is_constrained(site):
            beyond = locate_journal(site, z[:n]) / site.clearance - 1.0
            largest = max(largest, beyond if site.mode == FREE else -beyond)
            if site.mode != FREE:
                largest = max(largest, reversed_push(site, z[n : 2 * n]) / FORCE_SCALE)
            continue
        largest = max(largest, -site.f_n / FORCE_SCALE)
        if site.mode == ROLLING:
            largest = max(largest, friction_excess(site, site.f_n, site.f_t) / FORCE_SCALE)
        elif has_friction(site):
            largest = max(largest, reversed_slip(site, slip_velocity(site, z[n : 2 * n], Omega)))
    return largest


@kernel
def largest_penetration(sites: Sites, q: Array) -> float:
    """Return the largest penetration of free journals into their rigid retainers, relative to the clearance."""
    largest = 0.0
    for site in sites:
        if can_impact(site):
            largest = max(largest, locate_journal(site, q) / site.clearance - 1.0)
    return largest


@kernel
def locate_touch(w: Workspace, tau: float, dt: float) -> float:
    """Find the length (s) of the substep that ends on the first touch of a free site; 0 if it does not end on one.

    The cubic estimate is refined by Newton's method on the radius; z_new is set to the touch.
    """
    n = w.n
    stages = stages_of(w.stages)
    z, z_new = stages.z, stages.z_new
    first = -1
    trial = dt
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if can_touch(site) and locate_journal(site, z_new[:n]) > site.clearance:
            when = touch_time(site, z, z_new, dt, n)
            if first < 0 or when < trial:
                first, trial = k, when
    if first < 0:
        return 0.0
    site = w.sites[first]
    for _ in range(MAX_NEWTON_STEPS):
        substep(w, tau, trial)
        f = indicator(w.sites, z_new, n, spin_speed(w, tau + trial, z_new)) - EVENT_OFFSET
        if abs(f) < EVENT_OFFSET - TOLERANCE:
            return trial
        beyond = locate_journal(site, z_new[:n]) / site.clearance - 1.0 - EVENT_OFFSET
        outward = radial_component(site, z_new[n : 2 * n])
        if not outward > 0.0:
            break
        trial -= beyond * site.clearance / outward
        if not 0.0 < trial <= dt:
            break
    return 0.0


@kernel
def locate_event(w: Workspace, tau: float, dt: float) -> float:
    """Find the length (s) in (0, dt] of the substep that ends on the first event; z_new is set to it.

    Regula falsi by Anderson and Bjoerck for indicator = EVENT_OFFSET, just past the event; bisection while the left end
    lies on the event itself (a site that has just opened starts on the circle).
    """
    n = w.n
    stages = stages_of(w.stages)
    z, z_new = stages.z, stages.z_new
    low = 0.0
    high = dt
    f_high = indicator(w.sites, z_new, n, spin_speed(w, tau + dt, z_new)) - EVENT_OFFSET
    side = 0
    located = locate_touch(w, tau, dt)
    if located > 0.0:
        return located
    derivative(w, tau, z, stages.k_new)  # for the forces at z
    f_low = min(indicator(w.sites, z, n, spin_speed(w, tau, z)), 0.0) - EVENT_OFFSET
    for _ in range(100):
        if high - low <= 1e-15 * dt:
            break
        trial = 0.5 * (low + high)
        if f_low < -1e-6 * f_high:
            trial = low + (high - low) * f_low / (f_low - f_high)
        substep(w, tau, trial)
        f = indicator(w.sites, z_new, n, spin_speed(w, tau + trial, z_new)) - EVENT_OFFSET
        if abs(f) < EVENT_OFFSET - TOLERANCE:
            return trial
        if f > 0.0:
            if side == 1:
                f_low *= _share_of_other_end(f, f_high)
            high, f_high, side = trial, f, 1
        else:
            if side == -1:
                f_high *= _share_of_other_end(f, f_low)
            low, f_low, side = trial, f, -1
    substep(w, tau, high)
    return high


@kernel
def _share_of_other_end(f: float, before: float) -> float:
    """Return the weight of the value at the other end after the same end has been replaced twice."""
    share = 1.0 - f / before
    return share if share > 0.0 else 0.5


@kernel
def may_touch_between(w: Workspace, dt: float) -> bool:
    """Return whether the path of a free site from z to z_new may pass its retainer."""
    n = w.n
    stages = stages_of(w.stages)
    for site in w.sites:
        if not can_touch(site) or stays_within(site, stages.z, stages.z_new, dt, n, 0.0):
            continue
        if site.housing >= 0:
            return True
        if not leaves_or_stays_within(site, point_of(site, stages.z, n), point_of(site, stages.z_new, n), dt, 0.0):
            return True
    return False


@kernel
def apply_impacts(w: Workspace, Omega: float, law: int, rebounds: bool) -> bool:
    """Apply the impact law where free sites have reached their retainers; return False if no impulse exists."""
    n = w.n
    z = stages_of(w.stages).z
    q = z[:n]
    v = z[n : 2 * n]
    if not mark_touching(w.sites, q, v):
        return True
    if law == NODAL:
        nodal_impact(w, v, Omega)
        return True
    if not rebounds:
        for site in w.sites:
            site.rebound = 0.0
    return newton_impact(w, v, Omega)


@noinline_kernel
def advance(w: Workspace, solver: np.record, law: int, step_size: float, memory: np.record) -> int:
    """Advance z over a communication step of `step_size` (s); return a fault code.

    Substeps are at most `solver.max_substep` long, shorter during fast whirl, and end on events. They are halved, up to
    `MAX_HALVINGS` times, while the error of their velocities exceeds `solver.tolerance` (m/s). `memory.n_halvings`
    stores the number for the next step; `memory.tolerance_missed` is set if it was not enough. More than `MAX_SUBSTEPS`
    substeps are a fault, so every step ends.
    """
    n = w.n
    stages = stages_of(w.stages)
    substeps = max(math.ceil(step_size / solver.max_substep - 1e-9), 1)
    longest = step_size / substeps
    shortest = SHORTEST_FLIGHT * longest
    tau = 0.0
    taken = events = 0
    fault = resolve_modes(w, tau, shortest)
    if fault != 0:
        return fault
    while tau < step_size * (1.0 - 1e-12):
        if taken >= MAX_SUBSTEPS:
            return FAULT_TOO_STIFF
        taken += 1
        limit = substep_limit(w, spin_speed(w, tau, stages.z), longest)
        while True:
            dt = min(step_size - tau, limit, longest * 0.5**memory.n_halvings)
            if not substep(w, tau, dt):
                return FAULT_SINGULAR
            event = indicator(w.sites, stages.z_new, n, spin_speed(w, tau + dt, stages.z_new)) > TOLERANCE
            error = velocity_error(w, dt)
            accurate = error <= solver.tolerance and (event or not may_touch_between(w, dt))
            if memory.n_halvings >= MAX_HALVINGS or accurate:
                break
            memory.n_halvings += 1.0
        if error < GROW_RATIO * solver.tolerance and memory.n_halvings > 0.0:
            memory.n_halvings -= 1.0
        beyond_limit = events > EVENT_LIMIT
        if event:
            dt = locate_event(w, tau, dt)
            # strong friction can leave no consistent motion: time must go on all the same
            if beyond_limit and dt < MIN_EVENT_DISTANCE * step_size:
                dt = min(MIN_EVENT_DISTANCE * step_size, step_size - tau)
                substep(w, tau, dt)
                if largest_penetration(w.sites, stages.z_new[:n]) > MAX_PENETRATION:
                    return FAULT_TOO_MANY_EVENTS
        elif error > solver.tolerance:
            memory.tolerance_missed = 1.0
        collect_last_substep(w)
        tau += dt
        copy(stages.z_new, stages.z)
        copy(stages.k_new, stages.k_1)
        if event:
            events += 1
            if not apply_impacts(w, spin_speed(w, tau, stages.z), law, not beyond_limit):
                return FAULT_SINGULAR
            fault = resolve_modes(w, tau, longest if beyond_limit else shortest)
            if fault != 0:
                return fault
    return 0
