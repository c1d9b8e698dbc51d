"""Impacts: changes of velocity when journals touch their retainers (thesis 4.22, 4.23, and Newton's law)."""

from __future__ import annotations

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.constraints import multipliers, write_equations
from rotor_contact.contact.friction import (
    close_in_sliding,
    exceeds_static_impulse,
    has_friction,
    reversed_slip,
    start_sliding,
)
from rotor_contact.contact.response import add_contact_response
from rotor_contact.contact.site import (
    Site,
    Sites,
    can_impact,
    is_constrained,
    locate_journal,
    put_on_circle,
    radial_component,
    remove_radial_velocity,
    slip_velocity,
)
from rotor_contact.contact.site_totals import collect_impact
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.shaft.linear_solver import solve
from rotor_contact.shaft.products import quadratic_form
from rotor_contact.variables.enumerations import FREE, ROLLING, SLIDING


@kernel
def mark_touching(sites: Sites, q: Array, v: Array, rebound: float) -> bool:
    """Mark free sites whose journal has reached its retainer and moves outward; return whether there are any.

    `rebound` is 1, or 0 to omit restitution.
    """
    any_reached = False
    for site in sites:
        site.touching = 0
        site.rebound = rebound * site.restitution
        r = locate_journal(site, q)
        reached = can_impact(site) and r >= site.clearance * (1.0 - 1e-10)
        outward = radial_component(site, v) > 0.0
        if reached and (outward or r > site.clearance):
            # exactly on the circle, or a site that leaves again would look as if it touched
            put_on_circle(site, q)
            if outward:
                site.touching = 1
                any_reached = True
    return any_reached


@kernel
def nodal_impact(w: Workspace, v: Array, Omega: float) -> None:
    """Set only the radial velocity of each touching node to zero (4.22, 4.23), and let the node slide.

    This is the rule of the thesis, for fixed retainers. The rule does not conserve momentum, because the rest of the
    rotor keeps its velocity. The reported impulse is the impulse that Newton's law requires for the same velocity
    change, without rebound or friction.
    """
    stages = stages_of(w.stages)
    before = stages.before[: v.shape[0]]
    copy(v, before)
    for site in w.sites:
        if site.touching:
            close_in_sliding(site, v, Omega)
        site.mode_before = site.mode
    consistent = _find_impulses(w, v, before, Omega, 0.0)
    copy(before, v)
    for site in w.sites:
        site.mode = site.mode_before
        if site.touching:
            kinetic = quadratic_form(w.forms, v)
            remove_radial_velocity(site, v)
            if not consistent:
                site.p_n = site.p_t = 0.0
            collect_impact(site, 0.5 * (kinetic - quadratic_form(w.forms, v)))


@kernel
def newton_impact(w: Workspace, v: Array, Omega: float) -> bool:
    """Apply impulses at all touching and closed sites simultaneously; return False if no consistent set exists.

    v+ = v- - M^-1 J^T P with n . v+ = -e n . v- at touching sites, n . v+ = 0 at sites already closed, P >= 0 (sites
    that would be pulled are omitted), and a Coulomb impulse that opposes slip and cannot reverse it. The coefficient of
    friction is evaluated at the slip velocity before the impact.

    `site.touching` marks the sites that touch, and `site.rebound` is their coefficient of restitution e; v (m/s) is
    changed in place. If restitution and friction would create energy (possible with several coupled sites), the impact
    is repeated without them. The energy balance includes the energy that friction takes from the spin.
    """
    stages = stages_of(w.stages)
    before = stages.before[: v.shape[0]]
    copy(v, before)
    for site in w.sites:
        if site.touching:
            close_in_sliding(site, v, Omega)
        site.slip = slip_velocity(site, v, Omega)
        site.mode_before = site.mode
    for friction in (1.0, 0.0):
        for site in w.sites:
            site.mode = site.mode_before
        if not _find_impulses(w, v, before, Omega, friction):
            continue
        total = 0.0
        for site in w.sites:
            total += _heat(site, v, before, Omega)
        if total < -1e-12 * (1.0 + quadratic_form(w.forms, before)):
            continue
        for site in w.sites:
            collect_impact(site, _heat(site, v, before, Omega))
            if site.spin < 0:
                site.drive_work -= site.p_t * site.journal_radius * Omega
            if site.touching and radial_component(site, v) < -1e-12:
                site.mode = FREE
        return True
    return False


@kernel
def _heat(site: Site, v: Array, before: Array, Omega: float) -> float:
    """Return the heat (J) of a site's impulses, from the mean of its velocities before and after the impact."""
    approach = 0.5 * (radial_component(site, before) + radial_component(site, v))
    slip = 0.5 * (slip_velocity(site, before, Omega) + slip_velocity(site, v, Omega))
    heat: float = site.p_n * approach - site.p_t * slip
    return heat


@kernel
def _find_impulses(w: Workspace, v: Array, before: Array, Omega: float, friction: float) -> bool:
    """Find a consistent set of impulses p_n, p_t; return False if none exists.

    `friction` is 1, or 0 to omit restitution and sliding friction.
    """
    for _ in range(4 * w.sites.shape[0] + 2):
        size = write_equations(w, friction)
        for site in w.sites:
            if is_constrained(site):
                rebound = site.rebound if site.touching and friction != 0.0 else 0.0
                w.equations.right_side[site.unknown] = -(1.0 + rebound) * radial_component(site, before)
                if site.mode == ROLLING:
                    w.equations.right_side[site.unknown + 1] = -slip_velocity(site, before, Omega)
        if not solve(w.equations, size):
            return False
        copy(before, v)
        weakest = 0
        for k in range(w.sites.shape[0]):
            site = w.sites[k]
            site.p_n = 0.0
            site.p_t = 0.0
            if is_constrained(site):
                site.p_n, site.p_t = multipliers(site, w.equations, friction)
                add_contact_response(w, site, site.p_n, site.p_t, v)
            if site.p_n < w.sites[weakest].p_n:
                weakest = k
        if w.sites[weakest].p_n < 0.0:
            w.sites[weakest].mode = FREE
            continue
        if friction == 0.0 or not (_adjust_friction(w.sites, v, Omega) or _close_again(w.sites, v, Omega)):
            return True
    return False


@kernel
def _adjust_friction(sites: Sites, v: Array, Omega: float) -> bool:
    """Switch a site between slip and stick if its impulse requires it; return whether anything changed."""
    for site in sites:
        if not is_constrained(site):
            continue
        if site.mode == ROLLING and exceeds_static_impulse(site):
            start_sliding(site, site.p_t)
            return True
        if site.mode == SLIDING and has_friction(site) and reversed_slip(site, slip_velocity(site, v, Omega)) > 0.0:
            site.mode = ROLLING
            return True
    return False


@kernel
def _close_again(sites: Sites, v: Array, Omega: float) -> bool:
    """Close an omitted site whose journal approaches again due to other sites; return whether one was closed."""
    for site in sites:
        if site.mode == FREE and site.mode_before != FREE and radial_component(site, v) > 1e-9:
            close_in_sliding(site, v, Omega)
            return True
    return False
