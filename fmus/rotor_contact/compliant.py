"""Contact that yields: the classical force laws (thesis 4.1 to 4.9, 4.13), for comparison with the constraint.

With penetration delta = |r| - c > 0 and its rate delta', the normal force N >= 0 is

    linear                 k_c delta                                          (Hertz with n = 1)
    hertz                  K delta^(3/2)
    kelvin_voigt           k_c delta + c_c delta'
    kirk                   (k_c delta + c_c delta') psi,  psi = 1 - exp(-3 delta/delta_c)
    hunt_crossley          K delta^(3/2) (1 + 3/2 alpha_c delta')      restitution about 1 - alpha_c delta'(0)
    ulbrich                K delta^(3/2) (1 + 3/2 eta S),  S = tanh(delta'/v_s)
    switched_kelvin_voigt  F tanh(delta/delta_c) (1 + tanh(F/(k_c delta_c)))/2,  F = k_c delta + c_c delta'

with K = k_c / sqrt(delta_c), so that k_c is the secant stiffness at delta_c. Friction is T = -mu N tanh(v_slip/v_s): it
has no sticking, only slow creep. v_s is `SLIP_SCALE`.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import (
    MODE,
    NORMAL,
    PLANE,
    RADIUS,
    TANGENTIAL,
    locate,
    push,
    radial,
    slip_velocity,
)
from rotor_contact.interface import (
    ALPHA_C,
    C_C,
    CLEARANCE,
    CONSTRAINT,
    DELTA_C,
    ETA,
    FREE,
    HERTZ,
    HUNT_CROSSLEY,
    K_C,
    KELVIN_VOIGT,
    KIRK,
    LAW,
    LINEAR,
    MU,
    N_SITES,
    SWITCHED_KELVIN_VOIGT,
    ULBRICH,
)

SLIP_SCALE = 0.01  # m/s, over which friction turns its direction, and the phase of ulbrich its sign
RESOLUTION = 0.2  # of a contact's fastest time constant; a substep is no longer


@kernel
def yields(sites: Array, k: int) -> bool:
    """Whether site k is in contact under a force law."""
    return sites[k, LAW] != CONSTRAINT and sites[k, MODE] != FREE


@kernel
def progressive(law: float) -> bool:
    """Whether a law's force grows with the power 3/2 of the penetration."""
    return law in (HERTZ, HUNT_CROSSLEY, ULBRICH)


@kernel
def normal_force(sites: Array, k: int, delta: float, rate: float) -> float:
    """N (N) of site k's law at penetration `delta` >= 0 (m) and its `rate` (m/s)."""
    law = sites[k, LAW]
    depth = delta / sites[k, DELTA_C]
    elastic = sites[k, K_C] * delta
    viscous = elastic + sites[k, C_C] * rate
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
        force = elastic * math.sqrt(depth) * (1.0 + 1.5 * sites[k, ALPHA_C] * rate)
    elif law == ULBRICH:
        force = elastic * math.sqrt(depth) * (1.0 + 1.5 * sites[k, ETA] * math.tanh(rate / SLIP_SCALE))
    else:
        switch = 0.5 * (1.0 + math.tanh(viscous / (sites[k, K_C] * sites[k, DELTA_C])))
        force = viscous * math.tanh(depth) * switch
    return max(force, 0.0)


@kernel
def stored_energy(sites: Array, k: int, delta: float) -> float:
    """Elastic energy (J) of site k's law at penetration `delta` >= 0 (m): the integral of its force at rate zero.

    The switched law, whose integral has no simple form, counts k_c delta^2/2; the difference is heat and comes back.
    """
    law = sites[k, LAW]
    k_c = sites[k, K_C]
    if progressive(law):
        return 0.4 * k_c * delta * delta * math.sqrt(delta / sites[k, DELTA_C])
    if law == KIRK:
        d = sites[k, DELTA_C] / 3.0
        return k_c * (0.5 * delta * delta - d * d + d * (delta + d) * math.exp(-delta / d))
    return 0.5 * k_c * delta * delta


@kernel
def elastic_force(sites: Array, k: int, delta: float) -> float:
    """Derivative of `stored_energy` (N)."""
    law = sites[k, LAW]
    force: float = sites[k, K_C] * delta
    if progressive(law):
        return force * math.sqrt(delta / sites[k, DELTA_C])
    if law == KIRK:
        return force * (1.0 - math.exp(-3.0 * delta / sites[k, DELTA_C]))
    return force


@kernel
def apply_compliant(Minv: Array, sites: Array, q: Array, v: Array, Omega: float, a: Array) -> float:
    """Add the effect of yielding contacts to the acceleration `a`; returns the heat of their compression (W)."""
    heat = 0.0
    for k in range(N_SITES):
        if yields(sites, k):
            delta = max(locate(sites, k, q) - sites[k, CLEARANCE], 0.0)
            rate = radial(sites, k, v)
            normal = normal_force(sites, k, delta, rate)
            sites[k, NORMAL] = normal
            sites[k, TANGENTIAL] = -sites[k, MU] * normal * math.tanh(slip_velocity(sites, k, v, Omega) / SLIP_SCALE)
            heat += (normal - elastic_force(sites, k, delta)) * rate
            push(Minv, sites, k, normal, sites[k, TANGENTIAL], a)
    return heat


@kernel
def compliant_limit(Minv: Array, sites: Array, v: Array, Omega: float, longest: float) -> float:
    """Length (s) of a substep that resolves the vibration and damping of yielding contacts, at most `longest`."""
    limit = longest
    for k in range(N_SITES):
        if yields(sites, k):
            i = int(sites[k, PLANE])
            rate = abs(radial(sites, k, v))
            # as deep as it may come: at first touch there is no stiffness yet
            delta = max(sites[k, RADIUS] - sites[k, CLEARANCE], 0.0) + rate * limit
            depth = math.sqrt(delta / sites[k, DELTA_C]) if progressive(sites[k, LAW]) else 1.0
            stiffness = 1.5 * sites[k, K_C] * depth * (1.0 + 1.5 * sites[k, ALPHA_C] * rate)
            if sites[k, LAW] == KIRK or sites[k, LAW] == SWITCHED_KELVIN_VOIGT:
                stiffness += 3.0 * sites[k, C_C] * rate / sites[k, DELTA_C]
            per_force = 1.5 * (sites[k, ALPHA_C] + sites[k, ETA] / SLIP_SCALE)
            damping = sites[k, C_C] + per_force * sites[k, K_C] * delta * depth
            if abs(slip_velocity(sites, k, v, Omega)) < 3.0 * SLIP_SCALE:
                damping = max(damping, sites[k, MU] * sites[k, NORMAL] / SLIP_SCALE)
            fastest = math.sqrt(Minv[i, i] * stiffness) + Minv[i, i] * damping
            if fastest * limit > RESOLUTION:
                limit = RESOLUTION / fastest
    return limit
