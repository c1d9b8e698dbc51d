"""Compliant contact: sites that follow a force law of `contact_laws`, for comparison with the constraint.

The surfaces creep instead of sticking; see `friction.compliant_friction`.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.friction import compliant_friction, compliant_friction_damping
from rotor_contact.contact.response import add_contact_response, set_spin_response
from rotor_contact.contact.site import Site, Sites, locate_journal, radial_component, slip_velocity
from rotor_contact.contact.workspace import Workspace
from rotor_contact.variables.contact_laws import CONSTRAINT, compliant_response
from rotor_contact.variables.enumerations import FREE

RESOLUTION = 0.2  # of a contact's fastest time constant; a substep is no longer


@kernel
def is_compliant(site: Site) -> bool:
    """Return whether a site is in contact under a force law."""
    return site.law != CONSTRAINT and site.mode != FREE


@kernel
def is_any_compliant(sites: Sites) -> bool:
    """Return whether any site is in contact under a force law."""
    for site in sites:
        if is_compliant(site):
            return True
    return False


@kernel
def normal_force(site: Site, delta: float, rate: float) -> float:
    """Return the normal force N (N) of the site's law at penetration `delta` >= 0 (m), changing at `rate` (m/s)."""
    return max(compliant_response(site, delta, rate).force, 0.0)


@kernel
def _penetration(site: Site) -> float:
    """Return the penetration (m) of a journal whose radius is up to date."""
    return max(site.radius - site.clearance, 0.0)


@kernel
def reversed_push(site: Site, v: Array) -> float:
    """Return -`Response.push` (N), multiplied by the sign that `Response.push` had when contact was last resolved.

    The result is positive once N has passed its kink. The radius of the journal must be up to date.
    """
    return -float(site.push_sign) * push(site, v)


@kernel
def push(site: Site, v: Array) -> float:
    """Return `Response.push` (N); the radius of the journal must be up to date."""
    return compliant_response(site, _penetration(site), radial_component(site, v)).push


@noinline_kernel
def stored_energy(site: Site, delta: float) -> float:
    """Return the elastic energy (J) at penetration `delta` >= 0 (m)."""
    return compliant_response(site, delta, 0.0).stored


@kernel
def compression_heat(site: Site, v: Array) -> float:
    """Return the power (W) that the normal force of a compliant contact dissipates; this force must be up to date."""
    rate = radial_component(site, v)
    heat: float = (site.f_n - compliant_response(site, _penetration(site), rate).elastic) * rate
    return heat


@kernel
def apply_compliant(w: Workspace, z: Array, Omega: float, a: Array) -> None:
    """Add the effect of compliant contacts at z to the acceleration `a`."""
    n = w.n
    q = z[:n]
    v = z[n : 2 * n]
    for site in w.sites:
        if is_compliant(site):
            delta = max(locate_journal(site, q) - site.clearance, 0.0)
            normal = normal_force(site, delta, radial_component(site, v))
            site.f_n = normal
            site.f_t = compliant_friction(site, normal, slip_velocity(site, v, Omega))
            set_spin_response(w, site)
            add_contact_response(w, site, normal, site.f_t, a)


@kernel
def compliant_limit(Minv: Array, sites: Sites, v: Array, Omega: float, longest: float) -> float:
    """Return a substep length (s), at most `longest`, that resolves all compliant contacts."""
    limit = longest
    for site in sites:
        if is_compliant(site):
            mobility = Minv[site.row, site.row] + site.mobility
            rate = abs(radial_component(site, v))
            # the largest penetration that is possible: at first touch the stiffness is still zero
            at = compliant_response(site, _penetration(site) + rate * limit, rate)
            damping = max(at.damping, compliant_friction_damping(site, slip_velocity(site, v, Omega)))
            fastest = math.sqrt(mobility * at.stiffness) + mobility * damping
            if fastest * limit > RESOLUTION:
                limit = RESOLUTION / fastest
    return limit
