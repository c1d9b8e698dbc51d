"""Modes of the contact sites that are consistent with the forces at an instant."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.compliant import push
from rotor_contact.contact.constraints import project
from rotor_contact.contact.friction import (
    STICK_SPEED,
    close_in_sliding,
    friction_excess,
    has_friction,
    reversed_slip,
    start_sliding,
)
from rotor_contact.contact.site import (
    Sites,
    can_impact,
    is_constrained,
    locate_journal,
    radial_component,
    slip_velocity,
    tangential_component,
)
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.substeps.integration import derivative, spin_speed
from rotor_contact.variables.contact_laws import CONSTRAINT
from rotor_contact.variables.enumerations import FREE, ROLLING, SLIDING

FAULT_SINGULAR, FAULT_MODES = 2, 10

MAX_TENSION = 1e-9  # N, below which a normal force counts as none
# Of the clearance. Touches are located to 2e-11: flights that are hardly higher would go on forever, up to e = 0.9.
LOWEST_FLIGHT = 5e-11


@kernel
def resolve_modes(w: Workspace, tau: float, shortest: float) -> int:
    """Find modes that are consistent with the forces at z, without tension or excessive friction; store k_1.

    Sites that would touch again within `shortest` (s), or would hardly lift, count as closed. Otherwise, the bounces of
    one site, or of two sites in turn, would accumulate. Returns a fault code, because with strong friction there may be
    no consistent modes.
    """
    n = w.n
    stages = stages_of(w.stages)
    z, k_1 = stages.z, stages.k_1
    q = z[:n]
    v = z[n : 2 * n]
    Omega = spin_speed(w, tau, z)
    for site in w.sites:
        site.mode_fixed = 0
        if site.enabled != 0.0 and site.law != CONSTRAINT:
            site.mode = SLIDING if locate_journal(site, q) > site.clearance else FREE
            site.push_sign = 1.0 if push(site, v) > 0.0 else -1.0
    for _ in range(6 * w.sites.shape[0] + 1):
        project(w, q, v, Omega)
        if not derivative(w, tau, z, k_1):
            return FAULT_SINGULAR
        if not (
            _open_tensile(w.sites)
            or _change_friction(w.sites, v, Omega)
            or _close_soonest(w.sites, z, k_1[n : 2 * n], Omega, shortest)
        ):
            return 0
    return FAULT_MODES


@kernel
def _open_tensile(sites: Sites) -> bool:
    """Open the closed site with the largest tension; return whether there is one."""
    force = -MAX_TENSION
    opened = -1
    for k in range(sites.shape[0]):
        if is_constrained(sites[k]) and sites[k].f_n < force:
            opened = k
            force = sites[k].f_n
    if opened < 0:
        return False
    sites[opened].mode = FREE
    sites[opened].mode_fixed = 1
    return True


@kernel
def _close_soonest(sites: Sites, z: Array, a: Array, Omega: float, shortest: float) -> bool:
    """Close a free site whose journal lifts from its circle too briefly to be followed; return whether there is one.

    The flight would last 2 v/a and reach the height v^2/(2 a). It is too brief if it is shorter than `shortest` (s), or
    lower than `LOWEST_FLIGHT` times the clearance.
    """
    n = a.shape[0]
    v = z[n : 2 * n]
    for site in sites:
        if can_impact(site) and site.mode_fixed == 0:
            radius = locate_journal(site, z[:n])
            if radius >= site.clearance * (1.0 - 1e-10):
                outward = radial_component(site, a) + tangential_component(site, v) ** 2 / radius
                lowest = math.sqrt(8.0 * LOWEST_FLIGHT * site.clearance * max(outward, 0.0))
                if outward > 0.0 and -2.0 * radial_component(site, v) < max(shortest * outward, lowest):
                    close_in_sliding(site, v, Omega)
                    site.mode_fixed = 1
                    return True
    return False


@kernel
def _change_friction(sites: Sites, v: Array, Omega: float) -> bool:
    """Make a site stick if it stopped slipping, or slip if it cannot stick; return whether anything changed.

    Of several sites that cannot stick, the site furthest beyond its limit slips first, so that another may continue to
    roll. If an impact elsewhere has reversed the slip of a sliding site, the friction of this site is also reversed.
    """
    excess = 0.0
    loosest = -1
    for k in range(sites.shape[0]):
        if is_constrained(sites[k]) and sites[k].mode == ROLLING:
            beyond = friction_excess(sites[k], sites[k].f_n, sites[k].f_t)
            if beyond > excess:
                loosest = k
                excess = beyond
    if loosest >= 0:
        start_sliding(sites[loosest], sites[loosest].f_t)
        sites[loosest].mode_fixed = 1  # or it would stick again at this instant, while its slip is still zero
        return True
    for site in sites:
        if is_constrained(site) and site.mode == SLIDING and has_friction(site):
            slip = slip_velocity(site, v, Omega)
            if abs(slip) <= STICK_SPEED:
                if site.mode_fixed == 0:
                    site.mode = ROLLING
                    return True
            elif reversed_slip(site, slip) > 0.0:
                site.slip_sign = -site.slip_sign
                return True
    return False
