"""Force of one bearing axis and its linearisation (thesis 2.6 to 2.9).

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

from fmi_export.jit import kernel

MU_0 = 4e-7 * math.pi  # H/m, permeability of vacuum as the thesis uses it


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
