"""Force as a function of penetration when a mass hits a retainer once, under a force law of the plant."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from array_types import Array
from rotor_contact.contact.compliant import normal_force
from rotor_contact.contact.site import SITE, Site
from rotor_contact.variables.contact_laws import LAWS

ForceLaw = Callable[[float, float], float]
"""Normal force (N) at a penetration (m) and its rate (m/s)."""

POINTS = 401  # of a loop
LONGEST = 100.0  # largest duration of a blow, over the approximate one
LEAST_RESTITUTION = 0.15  # below it the spring and damper of (4.3) does not oscillate


def law_of_plant(law: str, k_c: float, delta_c: float, c_c: float, alpha_c: float, eta: float) -> ForceLaw:
    """Return a force law in the form in which the plant evaluates it (`rotor_contact.contact.compliant.normal_force`).

    Parameters
    ----------
    law
        Name of the law, one of `rotor_contact.variables.contact_laws.LAWS`.
    k_c, delta_c, c_c, alpha_c, eta
        Parameters of the site: stiffness (N/m), penetration (m), damping (N s/m), damping (s/m) and loss (1).
    """
    site: Site = np.zeros(1, SITE).view(np.recarray)[0]
    site.law, site.k_c, site.delta_c = LAWS.index(law), k_c, delta_c
    site.c_c, site.alpha_c, site.eta = c_c, alpha_c, eta
    return lambda delta, rate: float(normal_force(site, max(delta, 0.0), rate))


def blow(law: ForceLaw, mass: float, speed: float, duration: float) -> tuple[Array, Array, Array]:
    """Return penetration (m), its rate (m/s) and force (N), shape (n,) each, from first touch until the mass leaves.

    m delta'' = -N(delta, delta'),  delta(0) = 0,  delta'(0) = `speed`

    Parameters
    ----------
    law
        The force law.
    mass, speed
        Mass (kg) and speed of approach (m/s).
    duration
        Approximate duration of the contact (s); the mass must leave within a hundred times this duration.

    Raises
    ------
    ValueError
        If the mass does not leave in time.
    """

    def leaves(_: float, state: Array) -> float:
        return float(state[0])

    leaves.terminal, leaves.direction = True, -1  # type: ignore[attr-defined]
    depth = speed * duration
    motion = solve_ivp(
        lambda _, state: (state[1], -law(state[0], state[1]) / mass),
        (0.0, LONGEST * duration),
        (0.0, speed),
        method="DOP853",
        events=leaves,
        dense_output=True,
        max_step=duration / 50.0,
        rtol=1e-9,
        atol=(1e-9 * depth, 1e-9 * speed),
    )
    if not len(motion.t_events[0]):
        raise ValueError(
            f"a mass of {mass:g} kg at {speed:g} m/s does not leave the retainer within {LONGEST * duration:.3g} s"
        )
    delta, rate = motion.sol(np.linspace(0.0, motion.t[-1], POINTS))
    delta[[0, -1]] = 0.0
    return delta, rate, np.array([law(*state) for state in zip(delta, rate, strict=True)])


def damping_ratio_of(restitution: float) -> float:
    """Return the damping ratio zeta for which a spring-damper that never pulls has a given coefficient of restitution.

    e = exp(-zeta (pi - 2 asin zeta)/sqrt(1 - zeta^2))

    Parameters
    ----------
    restitution
        Coefficient of restitution e (1), from `LEAST_RESTITUTION` to 1.
    """

    def excess(zeta: float) -> float:
        return math.exp(-zeta * (math.pi - 2.0 * math.asin(zeta)) / math.sqrt(1.0 - zeta * zeta)) - restitution

    return float(brentq(excess, 0.0, 1.0 - 1e-9)) if restitution < 1.0 else 0.0
