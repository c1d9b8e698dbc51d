"""Amplifier and coil: the response of a coil pair's current to its command during a step, in closed form.

The command is constant over a step, so the current obeys a sequence of first-order equations:

    regulated            di/dt = omega (I_ref - i)          v = L di/dt + R i = L omega (I_ref - i) + R i
    at the voltage limit L di/dt = +-V - R i                as long as the regulator demands more than V
    off                  L di/dt = -V_d - R i               until i = 0; V_d = 0: only the coil's resistance

The voltage is at its limit until i reaches I_leave = (L omega I_ref -+ V)/(L omega - R), after a time given by a
logarithm, and does not reach the limit again before the command changes. A step of any length is exact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amb_actuator.force import limited_current
from amb_actuator.interface import DYNAMIC
from fmi_export.jit import kernel


class CoilPair(NamedTuple):
    """A coil pair of an axis, which carries the current i = operating_current + sign * deviation.

    operating_current
        Coil current at the operating point (A): I_s + I_b - I_m of the upper pair, I_b - I_m of the lower pair, with
        the part I_m of permanent magnets.
    sign
        +1 for the upper pair, -1 for the lower pair.
    deviation
        Deviation from the operating point at the beginning of the step (A), positive where it pulls towards +x.
    """

    operating_current: float
    sign: float
    deviation: float


class Course(NamedTuple):
    """The current over a part of a step: i = target + (begin - target) exp(-rate t).

    begin, target
        Currents (A).
    rate
        Rate of the approach (1/s).
    duration
        Length of the part (s); 0 if there is none.
    """

    begin: float
    target: float
    rate: float
    duration: float


class CoilResponse(NamedTuple):
    """A coil pair after a step.

    current
        At the end of the step (A).
    mean
        Average over the step (A).
    voltage
        At the end of the step (V).
    limited
        1 if the voltage was at its limit at any time in the step, else 0.
    first, last
        The current in the two parts of the step.
    """

    current: float
    mean: float
    voltage: float
    limited: float
    first: Course
    last: Course


@kernel
def demanded_current(p: np.record, u: np.record) -> float:
    """Return the demanded control current (A): a current, a voltage times the amplifier's gain, or the sum of both."""
    demand: float = u.demanded_current + p.amplifier_gain * u.command_voltage
    return demand


@kernel
def commanded_current(p: np.record, u: np.record, amplifier: float) -> float:
    """Limit the demanded control current to the I_c (A) that the coils and, if dynamic, the voltage limit can sustain.

    Both coil currents stay within [0, current_limit], and within R I <= V with a dynamic amplifier. Permanent magnets
    allow currents of both signs, see `force.least_and_most`.
    """
    limit = p.current_limit
    if amplifier == DYNAMIC:
        limit = min(limit, p.voltage_limit / p.resistance)
    return limited_current(demanded_current(p, u), p.bias_current, p.static_current, limit, p.permanent_bias)


@kernel
def first_order_response(i: float, target: float, z: float) -> tuple[float, float]:
    """Return the current after `z` time constants on its way from `i` to `target`, and its average up to then (A).

    i + (target - i) (1 - exp(-z))      and      i + (target - i) (z - 1 + exp(-z))/z
    """
    if z < 0.003:  # the difference would lose digits; the series is exact to the last digit
        lag = z * (1.0 / 2.0 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0)))))
    else:
        lag = 1.0 + math.expm1(-z) / z
    return i - (target - i) * math.expm1(-z), i + (target - i) * lag


@kernel
def held(i: float, duration: float) -> Course:
    """Return the course of a constant current (A)."""
    return Course(i, i, 0.0, duration)


@kernel
def constant_voltage_response(p: np.record, i: float, v: float, h: float) -> CoilResponse:
    """Advance a coil under a constant voltage `v` (V) for `h` (s): L di/dt = v - R i, from the current `i` (A)."""
    target = v / p.resistance
    current, mean = first_order_response(i, target, p.resistance * h / p.inductance)
    return CoilResponse(current, mean, v, 0.0, Course(i, target, p.resistance / p.inductance, h), held(current, 0.0))


@kernel
def discharge_response(p: np.record, i: float, h: float) -> CoilResponse:
    """Advance a coil whose amplifier is off for `h` (s), from the current `i` (A).

    Diodes feed the current back to the supply, against its voltage V_d, until it is zero.
    """
    v = -math.copysign(p.discharge_voltage, i)
    whole_step = constant_voltage_response(p, i, v, h)
    if math.copysign(1.0, i) * whole_step.current >= 0.0:
        return whole_step
    time_to_zero = p.inductance / p.resistance * math.log1p(p.resistance * abs(i) / p.discharge_voltage)
    discharge = constant_voltage_response(p, i, v, time_to_zero)
    return CoilResponse(0.0, discharge.mean * time_to_zero / h, 0.0, 0.0, discharge.first, held(0.0, h - time_to_zero))


@kernel
def regulated_response(p: np.record, i: float, target: float, h: float) -> CoilResponse:
    """Advance a coil under the current regulator with its voltage limit.

    Parameters
    ----------
    p
        Parameters of the axis.
    i, target
        Current at the beginning of the step and commanded current (A), both within +-V/R.
    h
        Length of the step (s).
    """
    r, inductance, limit = p.resistance, p.inductance, p.voltage_limit
    omega = 2.0 * math.pi * p.bandwidth
    gain = inductance * omega
    demanded_voltage = gain * (target - i) + r * i
    time_at_limit, mean_at_limit, limited, first = 0.0, i, 0.0, held(i, 0.0)
    # With gain < R the coil alone is faster than the regulator, which then never demands more than V.
    if abs(demanded_voltage) > limit and gain > r:
        v = math.copysign(limit, demanded_voltage)
        leave = (gain * target - v) / (gain - r)
        needed, available = r * (leave - i), v - r * i
        if abs(needed) >= -math.expm1(-r * h / inductance) * abs(available):
            whole_step = constant_voltage_response(p, i, v, h)
            return CoilResponse(whole_step.current, whole_step.mean, v, 1.0, whole_step.first, whole_step.last)
        time_at_limit = min(-inductance / r * math.log1p(-needed / available), h)
        at_limit = constant_voltage_response(p, i, v, time_at_limit)
        mean_at_limit, limited, first = at_limit.mean, 1.0, at_limit.first
        i = leave
    current, mean = first_order_response(i, target, omega * (h - time_at_limit))
    mean += (mean_at_limit - mean) * time_at_limit / h
    last = Course(i, target, omega, h - time_at_limit)
    return CoilResponse(current, mean, gain * (target - current) + r * current, limited, first, last)


@kernel
def coil_step(p: np.record, u: np.record, pair: CoilPair, i_c: float, amplifier: float, h: float) -> CoilResponse:
    """Advance a coil pair over a step; the returned currents are deviations from the operating point.

    Parameters
    ----------
    p, u
        Parameters and inputs of the axis.
    pair
        The coil pair at the beginning of the step.
    i_c
        Commanded control current (A).
    amplifier
        `IDEAL` or `DYNAMIC`.
    h
        Length of the step (s).
    """
    operating, sign = pair.operating_current, pair.sign
    if u.amplifier_off != 0.0:
        coil = discharge_response(p, operating + sign * pair.deviation, h)
    elif u.stuck != 0.0:
        return _held_coil(pair.deviation, p.resistance * (operating + sign * pair.deviation), h)
    elif amplifier == DYNAMIC:
        coil = regulated_response(p, operating + sign * pair.deviation, operating + sign * i_c, h)
    else:
        return _held_coil(i_c, p.resistance * (operating + sign * i_c), h)
    return CoilResponse(
        sign * (coil.current - operating),
        sign * (coil.mean - operating),
        coil.voltage,
        coil.limited,
        _deviating(pair, coil.first),
        _deviating(pair, coil.last),
    )


@kernel
def _deviating(pair: CoilPair, course: Course) -> Course:
    """Return the course of a current as that of its deviation from the operating point."""
    begin, target = course.begin - pair.operating_current, course.target - pair.operating_current
    return Course(pair.sign * begin, pair.sign * target, course.rate, course.duration)


@kernel
def _held_coil(deviation: float, voltage: float, h: float) -> CoilResponse:
    """Return a coil pair whose current (A), as a deviation, is constant over a step."""
    return CoilResponse(deviation, deviation, voltage, 0.0, held(deviation, h), held(deviation, 0.0))


@kernel
def steady_coil(p: np.record, u: np.record, pair: CoilPair, i_c: float) -> CoilResponse:
    """Return a coil pair in the steady state of its command `i_c` (A), or without current if the amplifier is off.

    As in `coil_step`, the currents are deviations from the operating point.
    """
    deviation = -pair.sign * pair.operating_current if u.amplifier_off != 0.0 else i_c
    return _held_coil(deviation, p.resistance * (pair.operating_current + pair.sign * deviation), 0.0)
