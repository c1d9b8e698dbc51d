"""Compliant contact: the classical force laws (thesis 4.1 to 4.9, 4.13), for comparison with the constraint.

docs/theory/contact_laws.md has their equations. With K = k_c / sqrt(delta_c) k_c is the secant stiffness at delta_c of
the laws with a power of 3/2; v_s there is `RATE_SCALE`. Friction creeps instead of sticking; see
`friction.compliant_friction`.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.friction import compliant_friction, compliant_friction_damping
from rotor_contact.contact.response import add_contact_response, set_spin_response
from rotor_contact.contact.site import (
    Site,
    Sites,
    locate_journal,
    radial_component,
    slip_velocity,
)
from rotor_contact.contact.workspace import Workspace
from rotor_contact.variables.enumerations import (
    CONSTRAINT,
    FREE,
    HERTZ,
    HUNT_CROSSLEY,
    KELVIN_VOIGT,
    KIRK,
    LINEAR,
    SWITCHED_KELVIN_VOIGT,
    ULBRICH,
)

RATE_SCALE = 0.01  # m/s, over which the phase of ulbrich changes its sign
RESOLUTION = 0.2  # of a contact's fastest time constant; a substep is no longer


@kernel
def is_compliant(site: Site) -> bool:
    """Return whether a site is in contact under a force law."""
    return site.law != CONSTRAINT and site.mode != FREE


@kernel
def is_any_compliant(sites: Sites) -> bool:
    """Return whether a site is in contact under a force law."""
    for site in sites:
        if is_compliant(site):
            return True
    return False


@kernel
def is_hertzian(law: float) -> bool:
    """Return whether a law's force grows with the power 3/2 of the penetration."""
    return law in (HERTZ, HUNT_CROSSLEY, ULBRICH)


@kernel
def normal_force(site: Site, delta: float, rate: float) -> float:
    """Return N (N) of the site's law at penetration `delta` >= 0 (m) and its `rate` (m/s)."""
    law = site.law
    depth = delta / site.delta_c
    elastic = site.k_c * delta
    viscous = elastic + site.c_c * rate
    force = 0.0
    if law == LINEAR:
        force = elastic
    elif law == HERTZ:
        force = elastic * math.sqrt(depth)
    elif law == KELVIN_VOIGT:
        force = viscous
    elif law == KIRK:
        force = viscous * (1.0 - math.exp(-3.0 * depth))
    elif law == HUNT_CROSSLEY:
        force = elastic * math.sqrt(depth) * (1.0 + 1.5 * site.alpha_c * rate)
    elif law == ULBRICH:
        force = elastic * math.sqrt(depth) * (1.0 + 1.5 * site.eta * math.tanh(rate / RATE_SCALE))
    else:
        switch = 0.5 * (1.0 + math.tanh(viscous / (site.k_c * site.delta_c)))
        force = viscous * math.tanh(depth) * switch
    return max(force, 0.0)


@kernel
def push(site: Site, v: Array) -> float:
    """Return a force (N) that is positive where the law pushes the journal, and negative where it would pull.

    Where the law would pull, N = 0. N therefore has a kink: for spring and damper at k_c delta + c_c delta' = 0, for
    the laws with power 3/2 where the factor of the rate vanishes. The radius of the journal must be up to date.
    """
    law, rate = site.law, radial_component(site, v)
    if law in (KELVIN_VOIGT, KIRK, SWITCHED_KELVIN_VOIGT):
        force: float = site.k_c * max(site.radius - site.clearance, 0.0) + site.c_c * rate
        return force
    factor = 1.0
    if law == HUNT_CROSSLEY:
        factor += 1.5 * site.alpha_c * rate
    elif law == ULBRICH:
        factor += 1.5 * site.eta * math.tanh(rate / RATE_SCALE)
    return factor * float(site.k_c * site.delta_c)


@kernel
def reversed_push(site: Site, v: Array) -> float:
    """Return -`push` (N) by its sign when contact was last resolved; positive once N has passed its kink."""
    return -float(site.push_sign) * push(site, v)


@noinline_kernel
def stored_energy(site: Site, delta: float) -> float:
    """Return the elastic energy (J) at penetration `delta` >= 0 (m): the integral of the force at rate zero.

    The integral of the switched law has no simple form; k_c delta^2/2 is used, and the difference counts as reversible
    heat.
    """
    k_c: float = site.k_c
    if is_hertzian(site.law):
        return 0.4 * k_c * delta * delta * math.sqrt(delta / site.delta_c)
    if site.law == KIRK:
        d = site.delta_c / 3.0
        return k_c * (0.5 * delta * delta - d * d + d * (delta + d) * math.exp(-delta / d))
    return 0.5 * k_c * delta * delta


@kernel
def elastic_force(site: Site, delta: float) -> float:
    """Return the derivative of `stored_energy` (N)."""
    force: float = site.k_c * delta
    if is_hertzian(site.law):
        return force * math.sqrt(delta / site.delta_c)
    if site.law == KIRK:
        return force * (1.0 - math.exp(-3.0 * delta / site.delta_c))
    return force


@kernel
def compression_heat(site: Site, v: Array) -> float:
    """Return the dissipation (W) of the normal force of a compliant contact, which must be up to date."""
    delta = max(site.radius - site.clearance, 0.0)
    heat: float = (site.f_n - elastic_force(site, delta)) * radial_component(site, v)
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
            rate = radial_component(site, v)
            normal = normal_force(site, delta, rate)
            site.f_n = normal
            site.f_t = compliant_friction(site, normal, slip_velocity(site, v, Omega))
            set_spin_response(w, site)
            add_contact_response(w, site, normal, site.f_t, a)


@kernel
def compliant_limit(Minv: Array, sites: Sites, v: Array, Omega: float, longest: float) -> float:
    """Return the length (s) of a substep that resolves all compliant contacts, at most `longest`."""
    limit = longest
    for site in sites:
        if is_compliant(site):
            mobility = Minv[site.row, site.row] + site.mobility
            rate = abs(radial_component(site, v))
            # the largest penetration that is possible: at first touch the stiffness is still zero
            delta = max(site.radius - site.clearance, 0.0) + rate * limit
            depth = math.sqrt(delta / site.delta_c) if is_hertzian(site.law) else 1.0
            stiffness = 1.5 * site.k_c * depth * (1.0 + 1.5 * site.alpha_c * rate)
            if site.law == KIRK or site.law == SWITCHED_KELVIN_VOIGT:
                stiffness += 3.0 * site.c_c * rate / site.delta_c
            per_force = 1.5 * (site.alpha_c + site.eta / RATE_SCALE)
            damping = site.c_c + per_force * site.k_c * delta * depth
            damping = max(damping, compliant_friction_damping(site, slip_velocity(site, v, Omega)))
            fastest = math.sqrt(mobility * stiffness) + mobility * damping
            if fastest * limit > RESOLUTION:
                limit = RESOLUTION / fastest
    return limit
