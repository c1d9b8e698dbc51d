"""The friction law: limit and direction of the friction at a site.

    sliding    T = -mu(v) N sign(v)                        v = v_slip (4.10, 4.11)
    rolling    |T| <= mu_s N,  mu_s = max(mu, mu_static)   (4.30 to 4.35)
    compliant  T = -mu(v) N tanh(v/v_r)                    contact under a force law, without sticking

N and T are forces, or impulses of an impact. The coefficient of sliding friction is constant, mu(v) = mu (Coulomb), or
falls with the slip velocity on the scale v_S = `stribeck_velocity` > 0 (Stribeck; thesis Fig. 1.1(d) without its
viscous part):

    mu(v) = mu + (mu_s - mu) exp(-(v/v_S)^2)

This is the Gaussian form of Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083-1138; unlike
exp(-|v|/v_S), it is smooth where the slip vanishes. The contact equations stay linear in N for any law, because mu is
evaluated at the slip velocity `site.slip` of the present state (in an impact, of the state before it).
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Site, slip_velocity
from rotor_contact.variables.enumerations import ROLLING, SLIDING

SLIP_SCALE = 0.01  # m/s, v_r: slip velocity over which friction of a compliant contact changes its direction
STICK_SPEED = 1e-9  # m/s, slip velocity that counts as none


@kernel
def kinetic_coefficient(site: Site, slip: float) -> float:
    """Return the coefficient of friction of a site that slides with the velocity `slip` (m/s)."""
    mu: float = site.mu
    if site.stribeck_velocity > 0.0:
        ratio = slip / site.stribeck_velocity
        mu += (static_coefficient(site) - mu) * math.exp(-ratio * ratio)
    return mu


@kernel
def static_coefficient(site: Site) -> float:
    """Return the coefficient of static friction mu_s."""
    return max(site.mu, site.mu_static)


@kernel
def has_friction(site: Site) -> bool:
    """Return whether a site can stick."""
    return static_coefficient(site) > 0.0


@kernel
def friction_ratio(site: Site, scale: float) -> float:
    """Return `scale` times T/N of a sliding site; for a rolling site, whose T is an unknown, return 0."""
    if site.mode == ROLLING:
        return 0.0
    ratio: float = -scale * kinetic_coefficient(site, site.slip) * site.slip_sign
    return ratio


@kernel
def friction_limit(site: Site, normal: float) -> float:
    """Return mu_s N, the largest friction with which a site sticks under a normal force (N) or impulse (N s)."""
    limit: float = static_coefficient(site) * normal
    return limit


@kernel
def friction_excess(site: Site, normal: float, friction: float) -> float:
    """Return |T| - mu_s N of forces (N) or impulses (N s); it is positive if a rolling site can no longer stick."""
    excess: float = abs(friction) - friction_limit(site, normal)
    return excess


@kernel
def exceeds_static_impulse(site: Site) -> bool:
    """Return whether the friction impulse of a rolling site is too large for it to stick."""
    return friction_excess(site, site.p_n, site.p_t) > 1e-12 * friction_limit(site, site.p_n)


@kernel
def reversed_slip(site: Site, slip: float) -> float:
    """Return a sliding site's slip velocity (m/s) in the direction of friction; it is positive once slip reverses."""
    velocity: float = -site.slip_sign * slip
    return velocity


@kernel
def close_in_sliding(site: Site, v: Array, Omega: float) -> None:
    """Close a site in sliding mode, in which friction opposes the present slip."""
    site.mode = SLIDING
    site.slip_sign = 1.0 if slip_velocity(site, v, Omega) >= 0.0 else -1.0


@kernel
def start_sliding(site: Site, friction: float) -> None:
    """Let a rolling site slide; its friction keeps the sign of `friction` (positive in the direction of spin)."""
    site.mode = SLIDING
    site.slip_sign = -1.0 if friction > 0.0 else 1.0


@kernel
def compliant_friction(site: Site, normal: float, slip: float) -> float:
    """Return T (N) of a compliant contact with normal force `normal` (N) and slip velocity `slip` (m/s)."""
    force: float = -kinetic_coefficient(site, slip) * normal * math.tanh(slip / SLIP_SCALE)
    return force


@kernel
def compliant_friction_damping(site: Site, slip: float) -> float:
    """Return a bound (N s/m) on the slope of compliant friction with respect to the slip velocity."""
    damping = 0.0
    if abs(slip) < 3.0 * SLIP_SCALE:
        damping = kinetic_coefficient(site, slip) * site.f_n / SLIP_SCALE
    if site.stribeck_velocity > 0.0:
        damping += (static_coefficient(site) - site.mu) * site.f_n / site.stribeck_velocity
    return damping


@kernel
def is_below_slip_scale(site: Site, slip: float) -> bool:
    """Return whether a compliant contact slips too slowly for full friction; such a contact counts as rolling."""
    return has_friction(site) and abs(slip) < SLIP_SCALE
