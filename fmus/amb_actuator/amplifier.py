"""Amplifier and coil: the response of a coil pair's current to its command during a step, in closed form.

The command is constant over a step, so the current obeys a sequence of first-order equations:

    regulated            di/dt = omega (I_ref - i)          v = L di/dt + R i = L omega (I_ref - i) + R i
    at the voltage limit L di/dt = +-V - R i                as long as the regulator demands more than V
    off                  L di/dt = -V_d - R i               until i = 0; V_d = 0: only the coil's resistance

The voltage is at its limit until i reaches I_leave = (L omega I_ref -+ V)/(L omega - R). The time at which i reaches
I_leave follows from a logarithm. The voltage does not reach the limit again before the command changes. The solution is
exact for a step of any length.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amb_actuator.force import limited_current
from amb_actuator.interface import DYNAMIC
from fmi_export.jit import inlined_kernel


class CoilPair(NamedTuple):
    """A coil pair of an axis, which carries the current i = operating_current + sign * deviation.

    operating_current
        Coil current at the operating point (A): I_s + I_b - I_m for the upper pair and I_b - I_m for the lower pair,
        where I_m is the part that permanent magnets contribute.
    sign
        +1 for the upper pair, -1 for the lower pair.
    deviation
        Deviation from the operating point at the beginning of the step (A), positive where it pulls towards +x.
    """

    operating_current: float
    sign: float
    deviation: float


class Course(NamedTuple):
    """The deviation of a current over a part of a step: i = target + (begin - target) exp(-rate t).

    begin, target
        Deviations (A).
    rate
        Rate of the approach (1/s); 0 if the current is constant.
    duration
        Length of the part (s); 0 if there is none.
    """

    begin: float
    target: float
    rate: float
    duration: float


class CoilCourses(NamedTuple):
    """The current of a coil pair during a step, in two parts, as deviations from the operating point.

    first
        First part, during which the voltage is at its limit or the coil discharges.
    last
        The rest of the step.
    voltage, per_current
        Coefficients (V, V/A) of the voltage in the last part: voltage + per_current (target - deviation). The voltage
        is R i + L di/dt, and the deviation changes at the rate times (target - deviation), so `per_current` is sign (L
        rate - R).
    limited
        1 if the voltage is at its limit at any time during the step, else 0.
    """

    first: Course
    last: Course
    voltage: float
    per_current: float
    limited: float


class CoilResponse(NamedTuple):
    """State of a coil pair after a step; its currents are deviations from the operating point.

    current
        Current at the end of the step (A).
    mean
        Average current over the step (A).
    voltage
        Voltage at the end of the step (V).
    limited
        1 if the voltage was at its limit at any time during the step, else 0.
    """

    current: float
    mean: float
    voltage: float
    limited: float


@inlined_kernel
def demanded_current(p: np.record, u: np.record) -> float:
    """Return the demanded control current (A): the demanded current plus gain times command voltage."""
    demand: float = u.demanded_current + p.amplifier_gain * u.command_voltage
    return demand


@inlined_kernel
def commanded_current(p: np.record, u: np.record, amplifier: float) -> float:
    """Return the demanded control current, limited to values I_c (A) that the coils and amplifier can sustain.

    Both coil currents stay within [0, current_limit]; if the amplifier is dynamic, they also satisfy R I <= V.
    Permanent magnets allow currents of both signs; see `force.least_and_most`.
    """
    limit = p.current_limit
    if amplifier == DYNAMIC:
        limit = min(limit, p.voltage_limit / p.resistance)
    return limited_current(demanded_current(p, u), p.bias_current, p.static_current, limit, p.permanent_bias)


@inlined_kernel
def first_order_response(i: float, target: float, z: float) -> tuple[float, float]:
    """Return the current after `z` time constants on its way from `i` to `target`, and its average up to then (A).

    i + (target - i) (1 - exp(-z))      and      i + (target - i) (z - 1 + exp(-z))/z
    """
    if z < 0.003:  # the difference would lose digits; the series is exact to the last digit
        lag = z * (1.0 / 2.0 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0)))))
    else:
        lag = 1.0 + math.expm1(-z) / z
    return i - (target - i) * math.expm1(-z), i + (target - i) * lag


@inlined_kernel
def end_and_mean(course: Course) -> tuple[float, float]:
    """Return the current at the end of a course, and its average over the course (A)."""
    if course.rate == 0.0:
        return course.begin, course.begin
    return first_order_response(course.begin, course.target, course.rate * course.duration)


@inlined_kernel
def held(deviation: float, duration: float) -> Course:
    """Return the course of a current that stays constant (A)."""
    return Course(deviation, deviation, 0.0, duration)


@inlined_kernel
def course_at_voltage(p: np.record, pair: CoilPair, v: float, duration: float) -> Course:
    """Return the course of the current under a constant voltage `v` (V): L di/dt = v - R i."""
    target = pair.sign * (v / p.resistance - pair.operating_current)
    return Course(pair.deviation, target, p.resistance / p.inductance, duration)


@inlined_kernel
def discharge(p: np.record, pair: CoilPair, h: float) -> CoilCourses:
    """Return the courses of the current during a step of `h` (s) while the amplifier is off.

    Diodes feed the current back to the supply, against the voltage V_d of the supply, until the current is zero.
    """
    i = pair.operating_current + pair.sign * pair.deviation
    direction = math.copysign(1.0, i)
    v, no_current = -direction * p.discharge_voltage, -pair.sign * pair.operating_current
    whole_step = course_at_voltage(p, pair, v, h)
    end, _ = end_and_mean(whole_step)
    if direction * (pair.operating_current + pair.sign * end) >= 0.0:
        return CoilCourses(held(pair.deviation, 0.0), whole_step, v, 0.0, 0.0)
    time_to_zero = p.inductance / p.resistance * math.log1p(p.resistance * abs(i) / p.discharge_voltage)
    first, last = course_at_voltage(p, pair, v, time_to_zero), held(no_current, h - time_to_zero)
    return CoilCourses(first, last, 0.0, 0.0, 0.0)


@inlined_kernel
def regulated(p: np.record, pair: CoilPair, i_c: float, h: float) -> CoilCourses:
    """Return the courses of the current while a regulator with limited voltage controls it.

    Parameters
    ----------
    p
        Parameters of the axis.
    pair
        The coil pair at the beginning of the step; its current and the commanded one are within +-V/R.
    i_c
        Commanded control current (A).
    h
        Length of the step (s).
    """
    r, inductance, limit = p.resistance, p.inductance, p.voltage_limit
    i, target = pair.operating_current + pair.sign * pair.deviation, pair.operating_current + pair.sign * i_c
    omega = 2.0 * math.pi * p.bandwidth
    gain = inductance * omega
    demanded_voltage = gain * (target - i) + r * i
    none, per_current = held(pair.deviation, 0.0), pair.sign * (gain - r)
    # With gain <= R the coil alone is faster than the regulator, which then never demands more than V.
    if abs(demanded_voltage) <= limit or gain <= r:
        return CoilCourses(none, Course(pair.deviation, i_c, omega, h), r * target, per_current, 0.0)
    v = math.copysign(limit, demanded_voltage)
    leave = (gain * target - v) / (gain - r)
    needed, available = r * (leave - i), v - r * i
    if abs(needed) >= -math.expm1(-r * h / inductance) * abs(available):
        return CoilCourses(none, course_at_voltage(p, pair, v, h), v, 0.0, 1.0)
    time_at_limit = min(-inductance / r * math.log1p(-needed / available), h)
    at_limit = course_at_voltage(p, pair, v, time_at_limit)
    rest = Course(pair.sign * (leave - pair.operating_current), i_c, omega, h - time_at_limit)
    return CoilCourses(at_limit, rest, r * target, per_current, 1.0)


@inlined_kernel
def coil_courses(p: np.record, u: np.record, pair: CoilPair, i_c: float, amplifier: float, h: float) -> CoilCourses:
    """Return the courses of a coil pair's current during a step.

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
    if u.amplifier_off != 0.0:
        return discharge(p, pair, h)
    if u.stuck == 0.0 and amplifier == DYNAMIC:
        return regulated(p, pair, i_c, h)
    deviation = pair.deviation if u.stuck != 0.0 else i_c
    voltage = p.resistance * (pair.operating_current + pair.sign * deviation)
    return CoilCourses(held(deviation, 0.0), held(deviation, h), voltage, 0.0, 0.0)


@inlined_kernel
def response(courses: CoilCourses, h: float) -> CoilResponse:
    """Return the state of a coil pair after a step of `h` (s) with these courses."""
    first, last = courses.first, courses.last
    current, mean = end_and_mean(last)
    if first.duration > 0.0:
        mean += (end_and_mean(first)[1] - mean) * first.duration / h
    voltage = courses.voltage + courses.per_current * (last.target - current)
    return CoilResponse(current, mean, voltage, courses.limited)


@inlined_kernel
def coil_step(p: np.record, u: np.record, pair: CoilPair, i_c: float, amplifier: float, h: float) -> CoilResponse:
    """Return the state of a coil pair after a step; the arguments are those of `coil_courses`."""
    return response(coil_courses(p, u, pair, i_c, amplifier, h), h)


@inlined_kernel
def steady_coil(p: np.record, u: np.record, pair: CoilPair, i_c: float) -> CoilResponse:
    """Return a coil pair in steady state under the command `i_c` (A), or without current if the amplifier is off."""
    deviation = -pair.sign * pair.operating_current if u.amplifier_off != 0.0 else i_c
    return CoilResponse(deviation, deviation, p.resistance * (pair.operating_current + pair.sign * deviation), 0.0)
