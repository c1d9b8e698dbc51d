"""Linear range, slew rate, load capacity and bandwidth of a magnetic bearing's axis, computed without a simulation.

The functions take the parameters of an axis as a record; see `axis_parameters`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np
from scipy.optimize import brentq

from amb_actuator.actuator import coil_currents
from amb_actuator.force import pull
from amb_cosim.model_constants.magnetic_bearing import (
    current_range,
    linear_constants,
    linearisation,
    static_current_for,
)
from array_types import Array


@dataclass(frozen=True)
class LinearRange:
    """Limits of the linear law in displacement x (m) at I_c = 0, and in control current I_c (A) at x = 0."""

    x: Annotated[tuple[float, float], "m"]
    i_c: Annotated[tuple[float, float], "A"]


class LoadCapacity(NamedTuple):
    """Static current (A) that carries each load, and remaining control force (N) along the load and against it."""

    static_current: Array
    up: Array
    down: Array


def linear_error(p: np.record, x: Array | float, i_c: Array | float) -> Array:
    """Return the error of the linear law F = K_s x + K_i I_c (2.7), relative to |K_s x| + |K_i I_c|.

    The reference is the force law (2.6), including saturation. Because the error is relative to the sum of magnitudes,
    it stays finite where the terms cancel. At the operating point, the error is 0. The parameters and exceptions are
    those of `linearisation`.
    """
    k_s, k_i = linear_constants(p)
    exact = linearisation(p, x, i_c).force
    stiff, driven = np.broadcast_arrays(k_s * np.asarray(x, dtype=float), k_i * np.asarray(i_c, dtype=float))
    size = np.abs(stiff) + np.abs(driven)
    return np.divide(np.abs(exact - stiff - driven), size, out=np.zeros(exact.shape), where=size > 0.0)


def linear_range(p: np.record, tolerance: float = 0.05) -> LinearRange:
    """Return the range in which the error of the linear law is at most `tolerance`, along x and along I_c.

    If the error is smaller everywhere, the range is limited by the gap or the coils.

    Raises
    ------
    ValueError
        If the tolerance is not between 0 and 1.
    """
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance = {tolerance:g} is not allowed; it must be between 0 and 1")
    low, high = current_range(p)
    gap = float(np.nextafter(p.gap, 0.0))
    x_low, x_high = (_first_crossing(lambda x: float(linear_error(p, x, 0.0)) - tolerance, end) for end in (-gap, gap))
    i_low, i_high = (_first_crossing(lambda i: float(linear_error(p, 0.0, i)) - tolerance, end) for end in (low, high))
    return LinearRange((x_low, x_high), (i_low, i_high))


def _first_crossing(excess: Callable[[float], float], end: float) -> float:
    """Return the first root of `excess` between 0 and `end`, or `end` if `excess` stays negative."""
    for inside, outside in pairwise(np.linspace(0.0, end, 401)):
        if excess(outside) > 0.0:
            return float(brentq(excess, inside, outside, xtol=1e-12 * abs(end)))
    return end


def force_slew_rate(p: np.record) -> tuple[float, float]:
    """Return the fastest rise and fall (N/s) of the force, with both coils at the voltage limit.

    dF/dt = K_upper (V - R a)/L + K_lower (V + R b)/L with the coil currents a = I_s + I_b - I_m and b = I_b - I_m. I_m
    represents permanent magnets. For a falling force, the signs of R are reversed.
    """
    a, b = map(float, coil_currents(p))
    k_upper = pull(p, p.static_current + p.bias_current, p.gap).per_current
    k_lower = pull(p, p.bias_current, p.gap).per_current
    v, r, inductance = p.voltage_limit, p.resistance, p.inductance
    rise = (k_upper * (v - r * a) + k_lower * (v + r * b)) / inductance
    fall = (k_upper * (v + r * a) + k_lower * (v - r * b)) / inductance
    return float(rise), float(fall)


def current_amplitude(p: np.record, frequency: Array | float) -> Array:
    """Return the largest amplitude (A) of the control current within coil and voltage limits at a frequency (Hz).

    The amplitude I is limited by R I_0 + I |R + j omega L| <= V for the coil pair with the larger current I_0 at rest.
    """
    low, high = current_range(p)
    impedance = np.hypot(p.resistance, 2.0 * math.pi * p.inductance * np.asarray(frequency, dtype=np.float64))
    return np.clip(_voltage_margin(p) / impedance, 0.0, min(-low, high))


def full_swing_bandwidth(p: np.record, amplitude: float) -> float:
    """Return the frequency (Hz) up to which the coils follow a sinusoidal control current of this amplitude (A).

    At this frequency, omega L = sqrt(((V - R I_0)/I)^2 - R^2). Above it, the voltage limit reduces the amplitude to
    `current_amplitude`.

    Raises
    ------
    ValueError
        If the amplitude is not positive, or exceeds the static limit of coils and voltage.
    """
    largest = float(current_amplitude(p, 0.0))
    if not 0.0 < amplitude <= largest:
        raise ValueError(f"amplitude = {amplitude:g} A is not allowed; it must be > 0 A and <= {largest:g} A")
    return float(math.sqrt((_voltage_margin(p) / amplitude) ** 2 - p.resistance**2) / (2.0 * math.pi * p.inductance))


def load_capacity(p: np.record, loads: Array) -> LoadCapacity:
    """Return the control force that remains when an axis carries static loads at its centre, with saturation.

    Each load determines the static current (`static_current_for`). The force is evaluated at the largest and at the
    smallest control current. Two axes at 45 degrees each carry 1/sqrt(2) of a vertical load.

    Parameters
    ----------
    p
        Parameters of the axis; its static current is ignored.
    loads
        Static loads of the axis (N), shape (n,).

    Raises
    ------
    ValueError
        If a load exceeds the capacity of the axis.
    """
    rows = []
    for load in np.asarray(loads, dtype=np.float64):
        q = p.copy()
        q.static_current = static_current_for(float(load), p)
        low, high = current_range(q)
        rows.append(
            (q.static_current, float(linearisation(q, 0.0, high).force), -float(linearisation(q, 0.0, low).force))
        )
    return LoadCapacity(*np.array(rows).reshape(-1, 3).T)


def voltage_at_rest(p: np.record) -> float:
    """Return the larger of the voltages R |I_0| (V) of an axis's coil pairs, where I_0 is a pair's current at rest."""
    return float(p.resistance * max(abs(current) for current in coil_currents(p)))


def _voltage_margin(p: np.record) -> float:
    return float(p.voltage_limit) - voltage_at_rest(p)
