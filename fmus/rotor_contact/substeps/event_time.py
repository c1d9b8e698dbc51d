"""The time of the first contact event in a substep.

Between events the motion is smooth. Each site has two indicators, smooth functions of time that rise through zero at an
event:

    free         gap closes             |r| - c
    constrained  normal force vanishes  -N
                 slip vanishes          -sign v_slip, if it slides
                 friction too small     |T| - mu_s N, if it rolls
    compliant    gap opens              c - |r|
                 pull begins or ends    -sign F of the law's factor F that changes sign

The substep is repeated with other lengths until the first indicator vanishes, so events are not rounded to steps. The
time is estimated for each indicator separately, because the largest of all indicators has kinks, at which regula falsi
stalls.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.compliant import reversed_push
from rotor_contact.contact.friction import friction_excess, has_friction, reversed_slip
from rotor_contact.contact.path import point_of, touch_time
from rotor_contact.contact.site import (
    Site,
    Sites,
    can_touch,
    is_constrained,
    locate_journal,
    radial_component,
    slip_velocity,
)
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.substeps.integration import derivative, spin_speed, substep
from rotor_contact.variables.enumerations import FREE, ROLLING

N_INDICATORS = 2  # of a site
FORCE_SCALE = 1e3  # N that count as much as 1 m/s of slip or a clearance: makes indicators comparable
TOLERANCE = 1e-12  # of the indicators, below which nothing has happened
EVENT_OFFSET = 1e-11  # value of the indicator at a located event
STARTS_ON_EVENT = 1e-6  # of the indicator at the end: a smaller one at the beginning gives no reliable slope


@kernel
def indicator_of(site: Site, which: int, z: Array, n: int, Omega: float) -> float:
    """Return indicator 0 or 1 (see above) of a site at z, with its forces at z; it is positive after an event."""
    if site.enabled == 0.0:
        return -1.0
    if not is_constrained(site):
        if which > 0:
            return reversed_push(site, z[n : 2 * n]) / FORCE_SCALE if site.mode != FREE else -1.0
        beyond = locate_journal(site, z[:n]) / site.clearance - 1.0
        return beyond if site.mode == FREE else -beyond
    if which == 0:
        return -site.f_n / FORCE_SCALE
    if site.mode == ROLLING:
        return friction_excess(site, site.f_n, site.f_t) / FORCE_SCALE
    return reversed_slip(site, slip_velocity(site, z[n : 2 * n], Omega)) if has_friction(site) else -1.0


@kernel
def indicator(sites: Sites, z: Array, n: int, Omega: float) -> float:
    """Return the largest of all indicators at z."""
    largest = -1.0
    for site in sites:
        for which in range(N_INDICATORS):
            largest = max(largest, indicator_of(site, which, z, n, Omega))
    return largest


@kernel
def locate_event(w: Workspace, tau: float, dt: float) -> float:
    """Return the length (s), in (0, dt], of the substep that ends on the first event; write its last state to z_new.

    The last substep must have had the length `dt` and contain an event. The method is regula falsi after Anderson and
    Bjoerck for every indicator. It begins with a value that is at least `EVENT_OFFSET` below zero. The time of a
    touch is found by Newton's method, starting from the time of the touch on the cubic path.
    """
    n, stages = w.n, stages_of(w.stages)
    z, z_new = stages.z, stages.z_new
    side = 0
    _move_end(w.sites, z_new, n, spin_speed(w, tau + dt, z_new), side == 0, side != 0)
    derivative(w, tau, z, stages.k_new)  # for the forces at z
    _move_end(w.sites, z, n, spin_speed(w, tau, z), side != 0, side != 0)
    for site in w.sites:
        for which in range(N_INDICATORS):
            site.before[which] = min(site.before[which], -EVENT_OFFSET)
    low, high, trial = 0.0, dt, dt
    for _ in range(100):
        if high - low <= 1e-15 * dt:
            break
        trial = _first_crossing(w, low, high, trial, side)
        substep(w, tau, trial)
        Omega = spin_speed(w, tau + trial, z_new)
        f = indicator(w.sites, z_new, n, Omega) - EVENT_OFFSET
        if abs(f) < EVENT_OFFSET - TOLERANCE:
            return trial
        new_side = 1 if f > 0.0 else -1
        _move_end(w.sites, z_new, n, Omega, new_side > 0, new_side == side)
        if new_side > 0:
            high = trial
        else:
            low = trial
        side = new_side
    substep(w, tau, high)
    return high


@kernel
def _move_end(sites: Sites, z: Array, n: int, Omega: float, is_end: bool, again: bool) -> None:
    """Set the indicators at the end (or the beginning) of the interval that contains the event to their values at z.

    If the same end also moved last time (`again`), the indicators at the other end are reduced (Anderson, Bjoerck).
    """
    for site in sites:
        for which in range(N_INDICATORS):
            f = indicator_of(site, which, z, n, Omega) - EVENT_OFFSET
            moved, other = (site.after, site.before) if is_end else (site.before, site.after)
            if again:
                share = 1.0 - f / moved[which] if moved[which] != 0.0 else 0.5
                other[which] *= share if share > 0.0 else 0.5
            moved[which] = f


@kernel
def _first_crossing(w: Workspace, low: float, high: float, last: float, side: int) -> float:
    """Return the estimate (s) of the first event between two times, one of which is `last`, the time of z_new.

    `side` is -1 if `last` is before the event, 1 if it is after the event, and 0 for the first estimate. An indicator
    that begins close to zero may fall before it rises, so the interval is halved if the slope of the indicator has led
    to a time before the event.
    """
    n, stages = w.n, stages_of(w.stages)
    first = high
    for site in w.sites:
        for which in range(N_INDICATORS):
            f_low, f_high = site.before[which], site.after[which]
            if not f_high > 0.0:
                continue
            estimate = 0.5 * (low + high)
            if side >= 0 or f_low < -STARTS_ON_EVENT * f_high:
                estimate = low + (high - low) * f_low / (f_low - f_high)
            if which == 0 and can_touch(site):
                touch = low
                outward = radial_component(site, stages.z_new[n : 2 * n])
                if side == 0:
                    touch = touch_time(site, point_of(site, stages.z, n), point_of(site, stages.z_new, n), high)
                elif outward > 0.0:
                    touch = last - (f_high if last == high else f_low) * site.clearance / outward
                if low < touch < high:
                    estimate = touch
            first = min(first, estimate)
    return first
