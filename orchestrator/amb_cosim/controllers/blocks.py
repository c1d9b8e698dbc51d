"""Controller blocks for magnetic bearings: conversion of tables in a file to continuous laws.

    gain          gain
    pid           kp + ki/s + kd s/(1 + s/w),  w = roll_off
    lead, lag     (1 + sqrt(a) s/w) / (1 + s/(sqrt(a) w)),  sin(phase) = (a - 1)/(a + 1): the phase at w, 1 at s = 0
    notch         (s^2 + 2 depth z w s + w^2) / (s^2 + 2 z w s + w^2),  z = damping: depth is the gain at w
                  w may be set at points over speed, linear between them
    band_stop     a notch of depth 0 with -3 dB at `low` and `high`: w^2 = low high, 2 z w = high - low
    low_pass      Butterworth of an order, -3 dB at `frequency`
    second_order  (s^2/v^2 + 2 y s/v + 1) / (s^2/w^2 + 2 z s/w + 1); without zeros the numerator is 1

W. Larsonneur in G. Schweitzer, E. H. Maslen, Magnetic Bearings, Springer, 2009, chapter 8, describes their use.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field

from amb_cosim.controllers.laws import Law, law_of, series_of_sections
from amb_cosim.cosim.system.tables import Table, Value
from amb_cosim.cosim.system.values import quantity, stated
from amb_files.speed_units import require_speed_unit

Points = Annotated[tuple[tuple[Value, Value], ...], Field(min_length=1, max_length=1000)]  # of (speed, value)
ValueOf = Callable[[Value, str], float]
Warp = Callable[[float], float]  # a frequency (rad/s) of a sampled law to that of the continuous law
OFF_CENTRE = 0.025  # of its half-width: error of the frequency of a notch between its points over speed


def angular_frequency(raw: Value, name: str) -> float:
    """Return a frequency in rad/s; a number is in Hz. Raises ValueError if it is not a frequency > 0."""
    text = f"{raw!r} Hz" if isinstance(raw, int | float) and not isinstance(raw, bool) else raw
    value = quantity(text, "rad/s", name)
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} = {raw} is not allowed; it must be a frequency > 0")
    return value


def _number(raw: Value, unit: str, name: str, low: float, high: float) -> float:
    value = quantity(raw, unit, name)
    if not low <= value <= high:
        suffix = "" if unit == "1" else f" {unit}"
        shown = stated(f"{value:g}{suffix}", raw)
        raise ValueError(f"{name} = {shown} is not allowed; it must be >= {low:g} and <= {high:g}{suffix}")
    return value


def schedule(points: Sequence[tuple[Value, Value]], name: str, value_of: ValueOf) -> list[tuple[float, float]]:
    """Return speeds (rad/s) and the value at each; raise ValueError if the speeds lack a unit or do not ascend."""
    where = f"speed of {name}"
    for speed, _ in points:
        require_speed_unit(str(speed), where)
    result = [(quantity(speed, "rad/s", where), value_of(raw, name)) for speed, raw in points]
    speeds = [speed for speed, _ in result]
    if speeds != sorted(set(speeds)):
        raise ValueError(f"the speeds of {name}, {speeds} rad/s, are not allowed; they must ascend")
    return result


class BlockTable(Table):
    """Base class of blocks."""

    def speeds(self) -> list[float]:
        """Return the speeds (rad/s) at which the block must be evaluated; empty if it does not depend on speed."""
        return []

    def at(self, speed: float) -> Self:
        """Return the block at a speed (rad/s)."""
        return self


class Gain(BlockTable):
    """A factor."""

    type: Literal["gain"]
    gain: float

    def law(self, warp: Warp) -> Law:
        return law_of(_number(self.gain, "1", "gain", -1e12, 1e12))


class Pid(BlockTable):
    """PID with roll-off."""

    type: Literal["pid"]
    kp: Value
    ki: Value = 0.0
    kd: Value = 0.0
    roll_off: Value | None = None

    def law(self, warp: Warp) -> Law:
        kp, ki, kd = (
            _number(raw, unit, name, -1e15, 1e15)
            for raw, unit, name in ((self.kp, "A/m", "kp"), (self.ki, "A/(m.s)", "ki"), (self.kd, "A.s/m", "kd"))
        )
        if kd == 0.0:
            return law_of(([kp, ki], [1.0, 0.0])) if ki else law_of(kp)
        if self.roll_off is None:
            raise ValueError("roll_off is missing; it is required with a derivative")
        tau = 1.0 / warp(angular_frequency(self.roll_off, "roll_off"))
        if ki == 0.0:
            return law_of(([kp * tau + kd, kp], [tau, 1.0]))
        return law_of(([kp * tau + kd, kp + ki * tau, ki], [tau, 1.0, 0.0]))


class LeadLag(BlockTable):
    """Phase lead or lag at a frequency."""

    type: Literal["lead", "lag"]
    frequency: Value
    phase: Value

    def law(self, warp: Warp) -> Law:
        w = warp(angular_frequency(self.frequency, "frequency"))
        text = self.phase if isinstance(self.phase, str) else f"{self.phase!r} deg"
        phase = math.radians(_number(text, "deg", "phase", 0.1, 85.0))
        a = (1.0 + math.sin(phase)) / (1.0 - math.sin(phase))
        root = math.sqrt(a if self.type == "lead" else 1.0 / a)
        return law_of(([root / w, 1.0], [1.0 / (root * w), 1.0]))


class Notch(BlockTable):
    """A notch with a damping and a depth, at a frequency that may depend on speed."""

    type: Literal["notch"]
    frequency: Value | Points
    damping: Value = 0.1
    depth: Value = 0.0

    def speeds(self) -> list[float]:
        """Return the speeds (rad/s) of the points, and additional speeds between them.

        Matrices are interpolated between these speeds, so w^2 varies linearly, and not w. Midway between speeds with
        the frequencies w and w (1 + d), the frequency is therefore too high by w d^2/8. If d = sqrt(8 OFF_CENTRE z),
        this error is the share `OFF_CENTRE` of the half-width z w.
        """
        points = self._frequencies()
        if not points:
            return []
        factor = math.sqrt(8.0 * OFF_CENTRE * self._damping())
        speeds = [points[0][0]]
        for (a, w_a), (b, w_b) in pairwise(points):
            count = max(1, math.ceil(abs(math.log(w_b / w_a)) / factor))
            between = np.geomspace(w_a, w_b, count + 1)[1:-1]
            speeds += [a + (b - a) * float((w - w_a) / (w_b - w_a)) for w in between]
            speeds.append(b)
        return speeds

    def at(self, speed: float) -> Self:
        points = self._frequencies()
        if not points:
            return self
        omega = float(np.interp(speed, *np.array(points).T))
        return self.model_copy(update={"frequency": f"{omega!r} rad/s"})

    def _frequencies(self) -> list[tuple[float, float]]:
        points = self.frequency
        return schedule(points, "frequency", angular_frequency) if isinstance(points, tuple) else []

    def _damping(self) -> float:
        return _number(self.damping, "1", "damping", 1e-6, 10.0)

    def law(self, warp: Warp) -> Law:
        assert not isinstance(self.frequency, tuple), "a law requires a single frequency; see `at`"
        w = warp(angular_frequency(self.frequency, "frequency"))
        z, depth = self._damping(), _number(self.depth, "1", "depth", 0.0, 1e3)
        return law_of(([1.0, 2.0 * depth * z * w, w * w], [1.0, 2.0 * z * w, w * w]))


class BandStop(BlockTable):
    """A band-stop filter between two frequencies."""

    type: Literal["band_stop"]
    low: Value
    high: Value

    def law(self, warp: Warp) -> Law:
        low, high = warp(angular_frequency(self.low, "low")), warp(angular_frequency(self.high, "high"))
        if low >= high:
            raise ValueError(f"low = {self.low} is not allowed; it must be below high = {self.high}")
        return law_of(([1.0, 0.0, low * high], [1.0, high - low, low * high]))


class LowPass(BlockTable):
    """A Butterworth low-pass."""

    type: Literal["low_pass"]
    frequency: Value
    order: Annotated[int, Field(ge=1, le=8)] = 2

    def law(self, warp: Warp) -> Law:
        w, n = warp(angular_frequency(self.frequency, "frequency")), self.order
        poles = [
            w * complex(-math.sin(angle), math.cos(angle))
            for angle in (math.pi * (2 * k + 1) / (2 * n) for k in range(n // 2))
        ]
        odd = [-w] if n % 2 else []
        return series_of_sections([], [*poles, *(pole.conjugate() for pole in poles), *odd], w**n)


class SecondOrder(BlockTable):
    """A second-order section defined by the frequencies and damping ratios of its poles and zeros."""

    type: Literal["second_order"]
    frequency: Value
    damping: Value
    zero_frequency: Value | None = None
    zero_damping: Value = 0.0

    def law(self, warp: Warp) -> Law:
        w, z = warp(angular_frequency(self.frequency, "frequency")), _number(self.damping, "1", "damping", 1e-6, 1e3)
        denominator = [1.0 / w**2, 2.0 * z / w, 1.0]
        if self.zero_frequency is None:
            return law_of(([1.0], denominator))
        v = warp(angular_frequency(self.zero_frequency, "zero_frequency"))
        y = _number(self.zero_damping, "1", "zero_damping", -1e3, 1e3)
        return law_of(([1.0 / v**2, 2.0 * y / v, 1.0], denominator))


Block = Annotated[
    Gain | Pid | LeadLag | Notch | BandStop | LowPass | SecondOrder, Field(discriminator="type", union_mode="smart")
]
