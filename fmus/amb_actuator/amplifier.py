"""Amplifier and coil: how the current of a coil pair follows its command during a step, in closed form.

The command is constant over a step, so the current obeys one first-order equation after the other:

    regulated            di/dt = omega (I_ref - i)          v = L di/dt + R i = L omega (I_ref - i) + R i
    at the voltage limit L di/dt = +-V - R i                as long as the regulator asks for more than V
    off                  L di/dt = -R i

It leaves the limit when i reaches I_leave = (L omega I_ref -+ V)/(L omega - R), at a time that a logarithm gives, and
does not come back to it before the command changes. One step, however long, is exact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from amb_actuator.force import limited_current
from amb_actuator.interface import (
    AMPLIFIER_GAIN,
    BANDWIDTH,
    BIAS,
    COMMAND_VOLTAGE,
    CURRENT_LIMIT,
    DEMAND,
    DYNAMIC,
    INDUCTANCE,
    OFF,
    RESISTANCE,
    STATIC,
    STUCK,
    VOLTAGE_LIMIT,
)
from fmi_export.jit import kernel
from fmi_export.model import Array


class Drive(NamedTuple):
    """One coil pair after a step.

    current
        At the end of the step (A).
    mean
        Average over the step (A).
    voltage
        At the end of the step (V).
    limited
        1 if the voltage was at its limit at any time in the step, else 0.
    """

    current: float
    mean: float
    voltage: float
    limited: float


@kernel
def demanded_current(p: Array, u: Array) -> float:
    """Control current asked for (A): as a current, as a voltage times the amplifier's gain, or as a sum of both."""
    demand: float = u[DEMAND] + p[AMPLIFIER_GAIN] * u[COMMAND_VOLTAGE]
    return demand


@kernel
def commanded_current(p: Array, u: Array, amplifier: float) -> float:
    """Control current I_c (A) that the coils can carry and, if dynamic, that the voltage limit can hold: R I <= V."""
    limit = p[CURRENT_LIMIT]
    if amplifier == DYNAMIC:
        limit = min(limit, p[VOLTAGE_LIMIT] / p[RESISTANCE])
    return limited_current(demanded_current(p, u), p[BIAS], p[STATIC], limit)


@kernel
def relaxed(i: float, goal: float, z: float) -> tuple[float, float]:
    """Current after `z` time constants on its way from `i` to `goal`, and its average up to then (A).

    i + (goal - i) (1 - exp(-z))      and      i + (goal - i) (z - 1 + exp(-z))/z
    """
    if z < 0.003:  # the difference would lose digits; the series is exact to the last one
        lag = z * (1.0 / 2.0 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0)))))
    else:
        lag = 1.0 + math.expm1(-z) / z
    return i - (goal - i) * math.expm1(-z), i + (goal - i) * lag


@kernel
def under_voltage(p: Array, i: float, v: float, h: float) -> Drive:
    """Coil under a constant voltage `v` (V) for `h` (s): L di/dt = v - R i."""
    current, mean = relaxed(i, v / p[RESISTANCE], p[RESISTANCE] * h / p[INDUCTANCE])
    return Drive(current, mean, v, 0.0)


@kernel
def regulated(p: Array, i: float, target: float, h: float) -> Drive:
    """Coil under the current regulator with its voltage limit.

    Parameters
    ----------
    p
        Parameters of the axis, in the order of the table.
    i, target
        Current at the beginning of the step and commanded current (A), both within +-V/R.
    h
        Length of the step (s).
    """
    r, inductance, limit = p[RESISTANCE], p[INDUCTANCE], p[VOLTAGE_LIMIT]
    omega = 2.0 * math.pi * p[BANDWIDTH]
    gain = inductance * omega
    asked = gain * (target - i) + r * i
    spent, mean_before, limited = 0.0, i, 0.0
    # With gain < R the coil alone is faster than the regulator, which then never asks for more than V.
    if abs(asked) > limit and gain > r:
        v = math.copysign(limit, asked)
        leave = (gain * target - v) / (gain - r)
        drop, driving = r * (leave - i), v - r * i
        if abs(drop) >= -math.expm1(-r * h / inductance) * abs(driving):
            held = under_voltage(p, i, v, h)
            return Drive(held.current, held.mean, v, 1.0)
        spent = min(-inductance / r * math.log1p(-drop / driving), h)
        mean_before = under_voltage(p, i, v, spent).mean
        limited = 1.0
        i = leave
    current, mean = relaxed(i, target, omega * (h - spent))
    mean += (mean_before - mean) * spent / h
    return Drive(current, mean, gain * (target - current) + r * current, limited)


@kernel
def coil_step(
    p: Array, u: Array, amplifier: float, at_rest: float, sign: float, d: float, i_c: float, h: float
) -> Drive:
    """One coil pair over a step; its currents here are deviations from the operating point.

    Parameters
    ----------
    p, u
        Parameters and inputs of the axis, in the order of the table.
    amplifier
        `IDEAL` or `DYNAMIC`.
    at_rest, sign
        Current at the operating point (A), and +1 for the upper pair or -1 for the lower: i = at_rest + sign d.
    d, i_c
        Deviation at the beginning of the step, and commanded control current (A).
    h
        Length of the step (s).
    """
    if u[OFF] != 0.0:
        coil = under_voltage(p, at_rest + sign * d, 0.0, h)
    elif u[STUCK] != 0.0:
        return Drive(d, d, p[RESISTANCE] * (at_rest + sign * d), 0.0)
    elif amplifier == DYNAMIC:
        coil = regulated(p, at_rest + sign * d, at_rest + sign * i_c, h)
    else:
        return Drive(i_c, i_c, p[RESISTANCE] * (at_rest + sign * i_c), 0.0)
    return Drive(sign * (coil.current - at_rest), sign * (coil.mean - at_rest), coil.voltage, coil.limited)


@kernel
def coil_at_start(p: Array, u: Array, at_rest: float, sign: float, i_c: float) -> Drive:
    """One coil pair that has had its command for long: as commanded, or without current where it is off."""
    d = -sign * at_rest if u[OFF] != 0.0 else i_c
    return Drive(d, d, p[RESISTANCE] * (at_rest + sign * d), 0.0)
