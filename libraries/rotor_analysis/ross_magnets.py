"""The magnetic bearings in a file saved by ROSS: geometry, bias and gains of their PID control."""

from __future__ import annotations

import cmath
import math
from typing import Any

from rotor_analysis.ross_parts import SavedBearing, SavedElement

MU_0 = 4e-7 * math.pi  # H/m, as in ROSS
TOLERANCE = 1e-6  # of a table's stiffness, by which that of the magnet may differ


class SavedMagnet(SavedElement):
    """A magnetic bearing with two equal axes; lengths in m, `ag` in m^2, `i0` in A, `alpha` in rad, gains per metre.

    g0, ag, nw, alpha, i0
        Gap, area of a pole, turns of two poles in series, half angle between the poles, bias current.
    kp_pid, ki_pid, kd_pid, n_f
        Gains of the control, and the frequency (rad/s) at which its derivative rolls off.
    k_amp, k_sense
        Gains of amplifier and sensor.
    """

    g0: float
    i0: float
    ag: float
    nw: float
    alpha: float
    kp_pid: float
    ki_pid: float
    kd_pid: float
    n_f: float
    k_amp: float
    k_sense: float
    sensor_node: int

    def dynamic_stiffness(self, omega: float) -> complex:
        """Return the closed-loop stiffness of an axis (N/m) at a whirl frequency (rad/s).

        K(s) = k_s + k_i k_amp k_sense [k_p + k_I/s + k_d s/(1 + s/n_f)],   s = j omega     (1)
        k_i = mu_0 n_w^2 a_g i_0 cos(alpha)/g_0^2,   k_s = -k_i i_0/g_0

        Source: G. Schweitzer, E. H. Maslen, Magnetic Bearings, Springer, 2009, chapters 3 and 4.
        """
        s = 1j * omega
        k_i = MU_0 * self.nw**2 * self.ag * self.i0 * math.cos(self.alpha) / self.g0**2
        control = self.kp_pid + self.ki_pid / s + self.kd_pid * s / (1.0 + s / self.n_f)
        return k_i * (self.k_amp * self.k_sense * control - self.i0 / self.g0)


def magnet_of(bearing: SavedBearing) -> SavedMagnet | None:
    """Return the magnet of a bearing if its table of coefficients by whirl frequency satisfies (1), otherwise None."""
    fields: dict[str, Any] = {"tag": bearing.tag, "n": bearing.n} | (bearing.model_extra or {})
    if not bearing.frequency or not set(SavedMagnet.model_fields) <= set(fields):
        return None
    magnet = SavedMagnet.model_validate({name: fields[name] for name in SavedMagnet.model_fields})
    for stiffness, damping in ((bearing.kxx, bearing.cxx), (bearing.kyy, bearing.cyy)):
        for omega, k, c in zip(bearing.frequency, stiffness, damping, strict=False):
            saved = k + 1j * omega * c
            if omega <= 0.0 or not cmath.isclose(magnet.dynamic_stiffness(omega), saved, rel_tol=TOLERANCE):
                return None
    return magnet
