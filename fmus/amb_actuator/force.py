"""Force of one bearing axis (thesis 2.6), its linearisation (2.7 to 2.9), and both of them with lost turns or currents.

    upper coil pair (I_s + I_b + I_c)          x > 0 towards the upper pair
          ========                             F > 0 towards the upper pair
             ^ F, x                            I_c > 0 strengthens the upper pair
          ( rotor )
          ========
    lower coil pair (I_b - I_c)

    F = K_s x + K_i I_c: both constants are positive. K_s > 0 pulls the rotor further away from the
    centre; the bearing is unstable without control.

`k_s`, `k_i` are constants of the bearing (N/m, N/A). They are not gains of the controller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from amb_actuator.flux import MU_0, flux_density, limited_flux, pull_of_flux
from amb_actuator.interface import (
    B_SAT,
    BIAS,
    GAP,
    HALF_ANGLE,
    K_I_MEASURED,
    K_S_MEASURED,
    KNEE,
    MEASURED,
    NONLINEAR,
    POLE_AREA,
    STATIC,
    TURNS,
)
from fmi_export.jit import kernel
from fmi_export.model import Array


class Coils(NamedTuple):
    """What decides the force besides the displacement.

    upper, lower
        Deviations of the two coil currents from the operating point (A), both positive where they pull towards
        positive x: the pairs carry I_s + I_b + upper and I_b - lower. A healthy bearing has both equal to I_c.
    upper_turns, lower_turns
        Shares of the turns that work, 0 to 1.
    """

    upper: float
    lower: float
    upper_turns: float
    lower_turns: float


class Pull(NamedTuple):
    """Pull of one coil pair (N), its decrease per distance (N/m) and its increase per ampere (N/A), all >= 0."""

    force: float
    per_distance: float
    per_current: float


@kernel
def negative_stiffness(
    turns: float, pole_area: float, gap: float, half_angle: float, bias: float, static: float
) -> float:
    """K_s of a bearing axis, the force per displacement at the operating point.

    K_s = 2 mu_0 A_e N^2 / l^3 cos(phi) [(I_s + I_b)^2 + I_b^2]     (2.8)

    Parameters
    ----------
    turns
        Turns per pole N.
    pole_area, gap
        Pole face area A_e (m^2) and air gap l (m).
    half_angle
        Half angle phi between the double pole faces (rad).
    bias, static
        Bias current I_b and static current I_s (A).

    Returns
    -------
    float
        K_s in N/m, positive: destabilising.
    """
    scale = 2.0 * MU_0 * pole_area * turns * turns / (gap * gap * gap) * math.cos(half_angle)
    return scale * ((static + bias) * (static + bias) + bias * bias)


@kernel
def current_stiffness(
    turns: float, pole_area: float, gap: float, half_angle: float, bias: float, static: float
) -> float:
    """K_i of a bearing axis, the force per control current at the operating point, in N/A.

    K_i = 2 mu_0 A_e N^2 / l^2 cos(phi) [I_s + 2 I_b]     (2.9)

    Parameters as in `negative_stiffness`.
    """
    scale = 2.0 * MU_0 * pole_area * turns * turns / (gap * gap) * math.cos(half_angle)
    return scale * (static + 2.0 * bias)


@kernel
def limited_current(demand: float, bias: float, static: float, limit: float) -> float:
    """Control current I_c (A) that keeps both coils, I_s + I_b + I_c and I_b - I_c, within [0, limit]."""
    low = max(-(static + bias), bias - limit)
    high = min(limit - (static + bias), bias)
    return min(max(demand, low), high)


@kernel
def pull(p: Array, current: float, distance: float) -> Pull:
    """Pull of a coil pair with a current (A) over a distance (m), P = B^2 A_e cos(phi)/mu_0, B limited by the iron.

    Without saturation P = mu_0 N^2 A_e cos(phi) I^2 / distance^2, one term of (2.6).
    """
    per_ampere = flux_density(p[TURNS], 1.0, distance)
    b = per_ampere * current
    flux, passed = limited_flux(b, p[B_SAT], p[KNEE])
    force = pull_of_flux(flux, p[POLE_AREA], p[HALF_ANGLE])
    slope = 2.0 * flux * passed * p[POLE_AREA] * math.cos(p[HALF_ANGLE]) / MU_0  # dP/db
    return Pull(force, slope * b / distance, slope * per_ampere)


@kernel
def nonlinear_force(p: Array, x: float, c: Coils) -> tuple[float, float]:
    """Force (N) in excess of the static load, and its gradient (N/m): P_upper - P_lower - F_0     (2.6)."""
    upper = pull(p, c.upper_turns * (p[STATIC] + p[BIAS] + c.upper), p[GAP] - x)
    lower = pull(p, c.lower_turns * (p[BIAS] - c.lower), p[GAP] + x)
    static = pull(p, p[STATIC] + p[BIAS], p[GAP]).force - pull(p, p[BIAS], p[GAP]).force
    return upper.force - lower.force - static, upper.per_distance + lower.per_distance


@kernel
def linear_force(p: Array, k_s: float, k_i: float, x: float, c: Coils) -> tuple[float, float]:
    """Force (N) and gradient (N/m) of the linear law F = K_s x + K_i I_c     (2.7).

    Where turns or bias are lost, it is (2.6) linearised about what is left. With a = I_s + I_b, b = I_b and the
    working shares n_u, n_l of the turns, currents are split into a bias level e and a control current,

        i_upper = e a + I_c,   i_lower = e b - I_c,   e = (i_upper + i_lower)/(a + b)

        F = K_s e^2 (n_u^2 a^2 + n_l^2 b^2)/(a^2 + b^2) x + K_i e (n_u^2 a + n_l^2 b)/(a + b) I_c
            + K_i/2 [e^2 (n_u^2 a^2 - n_l^2 b^2) - (a^2 - b^2)]/(a + b)

    A healthy bearing has e = 1 and the last term zero.
    """
    a, b = p[STATIC] + p[BIAS], p[BIAS]
    squares = a * a + b * b
    if squares == 0.0:  # no current at all, and none that could be lost
        return k_s * x, k_s
    level = 1.0 + (c.upper - c.lower) / (a + b)
    control = 0.5 * (c.upper + c.lower - (level - 1.0) * (a - b))
    n_u, n_l = c.upper_turns * c.upper_turns, c.lower_turns * c.lower_turns
    stiffness = k_s * (level * level * (n_u * a * a + n_l * b * b) / squares)
    per_current = k_i * (level * (n_u * a + n_l * b) / (a + b))
    lost = 0.5 * k_i / (a + b) * (level * level * (n_u * a * a - n_l * b * b) - (a * a - b * b))
    return stiffness * x + per_current * control + lost, stiffness


@kernel
def force(law: float, p: Array, x: float, c: Coils) -> tuple[float, float]:
    """Force (N) of an axis in excess of the static load, and its gradient over displacement (N/m).

    Parameters
    ----------
    law
        `LINEAR`, `MEASURED` or `NONLINEAR`.
    p
        Parameters of the axis, in the order of the table.
    x
        Displacement (m), |x| < gap.
    c
        Coil currents and working turns.
    """
    if law == NONLINEAR:
        return nonlinear_force(p, x, c)
    if law == MEASURED:
        return linear_force(p, p[K_S_MEASURED], p[K_I_MEASURED], x, c)
    k_s = negative_stiffness(p[TURNS], p[POLE_AREA], p[GAP], p[HALF_ANGLE], p[BIAS], p[STATIC])
    k_i = current_stiffness(p[TURNS], p[POLE_AREA], p[GAP], p[HALF_ANGLE], p[BIAS], p[STATIC])
    return linear_force(p, k_s, k_i, x, c)


@kernel
def beyond_knee(p: Array, x: float, c: Coils) -> bool:
    """Whether the flux density of a coil pair is where the iron begins to limit it, whatever the force law."""
    upper = flux_density(p[TURNS], c.upper_turns * (p[STATIC] + p[BIAS] + c.upper), p[GAP] - x)
    lower = flux_density(p[TURNS], c.lower_turns * (p[BIAS] - c.lower), p[GAP] + x)
    knee: float = (1.0 - p[KNEE]) * p[B_SAT]
    return max(upper, lower) > knee
