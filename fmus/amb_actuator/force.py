"""Force of a bearing axis (thesis 2.6) and its linearisation (2.7 to 2.9); turns and currents may be lost.

    upper coil pair (I_s + I_b + I_c)          x > 0 towards the upper pair
          ========                             F > 0 towards the upper pair
             ^ F, x                            I_c > 0 strengthens the upper pair
          ( rotor )
          ========
    lower coil pair (I_b - I_c)

    Permanent magnets, if there are any, count as a constant part I_m of the currents. The coils carry the rest, and
    only I_m remains without power.

    In F = K_s x + K_i I_c both constants are positive. The force K_s x pulls the rotor further away from the centre, so
    the bearing is unstable without control.

`k_s`, `k_i` are constants of the bearing (N/m, N/A). They are not gains of the controller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amb_actuator.flux import MU_0, flux_density, limited_flux, pull_of_flux
from amb_actuator.interface import MEASURED, NONLINEAR
from fmi_export.jit import kernel


class Coils(NamedTuple):
    """Coil currents and working turns, which determine the force together with the displacement.

    upper, lower
        Deviations of the two coil currents from the operating point (A). Both are positive if they increase the pull
        towards positive x. The upper current, including the part of permanent magnets, is I_s + I_b + upper; the lower
        one is I_b - lower. In a healthy bearing both deviations equal I_c.
    upper_turns, lower_turns
        Working fractions of the turns, 0 to 1.
    """

    upper: float
    lower: float
    upper_turns: float
    lower_turns: float


class Pull(NamedTuple):
    """Pull of a coil pair (N), its decrease per metre of distance (N/m) and its increase per ampere (N/A), all >= 0."""

    force: float
    per_distance: float
    per_current: float


@kernel
def negative_stiffness(p: np.record) -> float:
    """Return K_s of a bearing axis (N/m), the force per displacement at the operating point; K_s > 0 is destabilising.

    K_s = 2 mu_0 A_e N^2 / l^3 cos(phi) [(I_s + I_b)^2 + I_b^2]     (2.8)

    Parameters
    ----------
    p
        Parameters of the axis: turns N, pole_area A_e, gap l, half_angle phi, bias_current I_b, static_current I_s.
    """
    operating, bias = p.static_current + p.bias_current, p.bias_current
    scale = 2.0 * MU_0 * p.pole_area * p.turns * p.turns / (p.gap * p.gap * p.gap) * math.cos(p.half_angle)
    return scale * (operating * operating + bias * bias)


@kernel
def current_stiffness(p: np.record) -> float:
    """Return K_i of a bearing axis (N/A), the force per control current at the operating point.

    K_i = 2 mu_0 A_e N^2 / l^2 cos(phi) [I_s + 2 I_b]     (2.9)

    Parameters as in `negative_stiffness`.
    """
    scale = 2.0 * MU_0 * p.pole_area * p.turns * p.turns / (p.gap * p.gap) * math.cos(p.half_angle)
    return scale * (p.static_current + 2.0 * p.bias_current)


@kernel
def current_per_displacement(law: float, p: np.record) -> float:
    """Return K_s/K_i of a linear law (A/m), the current with the same force as a unit displacement; 0 if K_i = 0."""
    k_s, k_i = negative_stiffness(p), current_stiffness(p)
    if law == MEASURED:
        k_s, k_i = p.k_s_measured, p.k_i_measured
    ratio: float = k_s / k_i if k_i != 0.0 else 0.0
    return ratio


@kernel
def least_and_most(limit: float, permanent: float) -> tuple[float, float]:
    """Return the least and the largest current (A) of a coil pair, including the part of its permanent magnets.

    The coil itself carries at most +-limit, and does not reverse the flux.
    """
    return max(0.0, permanent - limit), permanent + limit


@kernel
def limited_current(demand: float, bias: float, static: float, limit: float, permanent: float) -> float:
    """Limit a control current (A) so that I_s + I_b + I_c and I_b - I_c stay within `least_and_most`."""
    least, most = least_and_most(limit, permanent)
    low = max(least - (static + bias), bias - most)
    high = min(most - (static + bias), bias - least)
    return min(max(demand, low), high)


@kernel
def pull(p: np.record, current: float, distance: float) -> Pull:
    """Return the pull of a coil pair across a distance (m), given its current (A): P = B^2 A_e cos(phi)/mu_0.

    Saturation of the iron limits B. Without saturation, P = mu_0 N^2 A_e cos(phi) I^2 / distance^2, which is a term of
    (2.6).
    """
    per_ampere = flux_density(p.turns, 1.0, distance)
    b = per_ampere * current
    flux, flux_slope = limited_flux(b, p.b_sat, p.knee_width)
    force = pull_of_flux(flux, p.pole_area, p.half_angle)
    slope = 2.0 * flux * flux_slope * p.pole_area * math.cos(p.half_angle) / MU_0  # dP/db
    return Pull(force, slope * b / distance, slope * per_ampere)


@kernel
def static_pull(p: np.record) -> float:
    """Return the static load F_0 (N) by (2.6), which a healthy axis carries at its centre without control current."""
    return pull(p, p.static_current + p.bias_current, p.gap).force - pull(p, p.bias_current, p.gap).force


@kernel
def nonlinear_force(p: np.record, x: float, c: Coils, total: bool = False) -> tuple[float, float]:
    """Return P_upper - P_lower (N), minus F_0 unless `total` is true, and its gradient (N/m) (2.6)."""
    upper = pull(p, c.upper_turns * (p.static_current + p.bias_current + c.upper), p.gap - x)
    lower = pull(p, c.lower_turns * (p.bias_current - c.lower), p.gap + x)
    carried = 0.0 if total else static_pull(p)
    return upper.force - lower.force - carried, upper.per_distance + lower.per_distance


@kernel
def linear_force(p: np.record, k_s: float, k_i: float, x: float, c: Coils, total: bool = False) -> tuple[float, float]:
    """Return the force (N) and its gradient (N/m) of the linear law F = K_s x + K_i I_c     (2.7).

    If turns or bias are lost, the law is (2.6) linearised about the operating point that remains. Let a = I_s + I_b and
    b = I_b, and let n_u and n_l be the working fractions of the turns. The currents are split into a bias level e and a
    control current:

        i_upper = e a + I_c,   i_lower = e b - I_c,   e = (i_upper + i_lower)/(a + b)

        F = K_s e^2 (n_u^2 a^2 + n_l^2 b^2)/(a^2 + b^2) x + K_i e (n_u^2 a + n_l^2 b)/(a + b) I_c
            + K_i/2 [e^2 (n_u^2 a^2 - n_l^2 b^2) - (a^2 - b^2)]/(a + b)

    For a healthy bearing e = 1, and the last term is zero. For the `total` force, a^2 - b^2 is omitted from this term.
    The force at the centre of a healthy bearing is then F_0 = K_i/2 I_s, as follows from (2.6) and (2.9). It is zero
    if there are no currents.
    """
    a, b = p.static_current + p.bias_current, p.bias_current
    squares = a * a + b * b
    if squares == 0.0:  # without bias the control current is zero, too
        return k_s * x, k_s
    level = 1.0 + (c.upper - c.lower) / (a + b)
    control = 0.5 * (c.upper + c.lower - (level - 1.0) * (a - b))
    n_u, n_l = c.upper_turns * c.upper_turns, c.lower_turns * c.lower_turns
    stiffness = k_s * (level * level * (n_u * a * a + n_l * b * b) / squares)
    per_current = k_i * (level * (n_u * a + n_l * b) / (a + b))
    carried = 0.0 if total else a * a - b * b
    lost = 0.5 * k_i / (a + b) * (level * level * (n_u * a * a - n_l * b * b) - carried)
    return stiffness * x + per_current * control + lost, stiffness


@kernel
def force(law: float, p: np.record, x: float, c: Coils, total: bool = False) -> tuple[float, float]:
    """Return the force (N) of an axis and its gradient with respect to displacement (N/m).

    Parameters
    ----------
    law
        `LINEAR`, `MEASURED` or `NONLINEAR`.
    p
        Parameters of the axis.
    x
        Displacement (m), |x| < gap.
    c
        Coil currents and working turns.
    total
        Whether to return the total force instead of the force in excess of the static load F_0.
    """
    if law == NONLINEAR:
        return nonlinear_force(p, x, c, total)
    if law == MEASURED:
        return linear_force(p, p.k_s_measured, p.k_i_measured, x, c, total)
    return linear_force(p, negative_stiffness(p), current_stiffness(p), x, c, total)


@kernel
def is_beyond_knee(p: np.record, x: float, c: Coils) -> bool:
    """Return whether the flux density of a coil pair exceeds the knee of saturation, regardless of the force law."""
    upper = flux_density(p.turns, c.upper_turns * (p.static_current + p.bias_current + c.upper), p.gap - x)
    lower = flux_density(p.turns, c.lower_turns * (p.bias_current - c.lower), p.gap + x)
    knee: float = (1.0 - p.knee_width) * p.b_sat
    return max(upper, lower) > knee
