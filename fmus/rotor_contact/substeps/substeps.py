"""Motion through contact events.

Substeps end on events (`event_time`). At an event, modes and velocities change; the integration then continues.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.impact import mark_touching, newton_impact, nodal_impact
from rotor_contact.contact.path import keeps_distance, leaves_or_stays_within, point_of
from rotor_contact.contact.site import Sites, can_impact, can_touch, locate_journal
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.substeps.contact_modes import FAULT_SINGULAR, resolve_modes
from rotor_contact.substeps.event_time import TOLERANCE, indicator, locate_event
from rotor_contact.substeps.integration import collect_last_substep, spin_speed, substep, substep_limit, velocity_error
from rotor_contact.variables.enumerations import NODAL

FAULT_TOO_MANY_EVENTS, FAULT_TOO_STIFF = 1, 8

MAX_SUBSTEPS = 1e5  # of a communication step

EVENT_LIMIT = 50  # events in `advance`; beyond it impacts do not rebound and flights shorter than a substep are skipped
MIN_EVENT_DISTANCE = 1.0 / 200.0  # of the time to advance, between two events beyond that limit; bounds their number
MAX_PENETRATION = 1e-2  # of the clearance, by which a journal may then penetrate its retainer
SHORTEST_FLIGHT = 1e-3  # of a substep; a shorter flight is sustained contact
MAX_HALVINGS = 2.0  # of a substep for the sake of accuracy
GROW_RATIO = 0.03  # of the tolerance: a substep of twice the length would meet it too, the estimate is of fourth order


@kernel
def largest_penetration(sites: Sites, q: Array) -> float:
    """Return the largest penetration of free journals into their rigid retainers, relative to the clearance."""
    largest = 0.0
    for site in sites:
        if can_impact(site):
            largest = max(largest, locate_journal(site, q) / site.clearance - 1.0)
    return largest


@kernel
def may_touch_between(w: Workspace, dt: float) -> bool:
    """Return whether the path of any free journal from z to z_new may cross its retainer."""
    stages = stages_of(w.stages)
    for site in w.sites:
        if can_touch(site):
            begin, end = point_of(site, stages.z, w.n), point_of(site, stages.z_new, w.n)
            if not keeps_distance(site, begin, end, dt, 0.0) and (
                site.housing >= 0 or not leaves_or_stays_within(site, begin, end, dt, 0.0)
            ):
                return True
    return False


@kernel
def apply_impacts(w: Workspace, Omega: float, law: int, rebound: float) -> bool:
    """Apply the impact law where free journals have reached their retainers; return False if no impulse exists.

    `rebound` is 1, or 0 to omit restitution.
    """
    n = w.n
    z = stages_of(w.stages).z
    q = z[:n]
    v = z[n : 2 * n]
    if not mark_touching(w.sites, q, v, rebound):
        return True
    if law == NODAL:
        nodal_impact(w, v, Omega)
        return True
    return newton_impact(w, v, Omega)


@noinline_kernel
def advance(w: Workspace, settings: np.record, step_size: float, memory: np.record) -> int:
    """Advance z over a time `step_size` (s); return a fault code. `settings` are the single parameters.

    Substeps are at most `solver.max_substep` long, shorter during fast whirl, and end on events. They are halved, up to
    `MAX_HALVINGS` times, while the error of their velocities exceeds `solver.tolerance` (m/s). `memory.n_halvings`
    stores the number of halvings for the next step; `memory.tolerance_missed` is set if `MAX_HALVINGS` halvings were
    not sufficient. More than `MAX_SUBSTEPS` substeps cause a fault, so every step ends.
    """
    n, stages = w.n, stages_of(w.stages)
    solver, law = settings.solver, int(settings.contact.impact_law)
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
            # with strong friction there may be no consistent motion, but time must advance
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
            if not apply_impacts(w, spin_speed(w, tau, stages.z), law, 0.0 if beyond_limit else 1.0):
                return FAULT_SINGULAR
            fault = resolve_modes(w, tau, longest if beyond_limit else shortest)
            if fault != 0:
                return fault
    return 0
