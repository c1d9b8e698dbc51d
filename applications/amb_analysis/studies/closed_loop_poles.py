"""Study of the poles of the levitated rotor under its controller, as a function of the spin speed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.linear.loop import CLOSE, Loop
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.inputs import DEFAULT_RANGE, Number, controlled, speed_range
from amb_analysis.studies.loop_vibrations import (
    Direction,
    LeastDamped,
    Vibrations,
    begun_later,
    followed,
    least_damped,
    vibrations,
    vibrations_over,
    whirl_of,
)
from amb_analysis.studies.result import MachineResult
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import frequency_unit, speed_unit
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import require
from array_types import Array
from rotor_analysis.refinement import with_samples
from rotor_analysis.tracking import RESONANT

POINTS = 61  # speeds of the diagram, before those of tables and near critical speeds are added
ROUNDS = 6  # of adding samples at critical speeds
LOWEST = 1e-3  # first speed over the highest: a rotor at rest has no sense of whirl


@dataclass(frozen=True, eq=False)
class PoleOverSpeed:
    """A vibration, followed over the speeds of the diagram; its values are NaN where it does not oscillate.

    frequencies
        Damped frequencies |Im s| (rad/s), shape (n,).
    damping_ratios
        -Re s / |s| (1), shape (n,); negative where the loop is not stable.
    decrements
        Logarithmic decrements, -2 pi Re s / |Im s| (1), shape (n,). A decrement is the logarithm of the ratio of
        successive amplitudes.
    whirl
        Sense of whirl at the bearings, or `axial` for a vibration along the shaft; None where there is no vibration.
    """

    frequencies: Annotated[Array, "rad/s"]
    damping_ratios: Array
    decrements: Array
    whirl: tuple[Direction | None, ...]


@dataclass(frozen=True)
class CriticalCrossing:
    """A spin speed at which the frequency of a vibration equals the frequency of rotation.

    mode
        Number of the vibration, from 1.
    speed
        The spin speed (rad/s).
    decrement
        Logarithmic decrement of the vibration at this speed (1).
    whirl
        Sense of whirl at the bearings; unbalance hardly excites a backward whirl.
    """

    mode: int
    speed: float
    decrement: float
    whirl: Direction


@dataclass(frozen=True, eq=False, repr=False)
class ClosedLoopPoles(MachineResult):
    """Poles of the sampled loop over the spin speed, z = exp(s T).

    sample_time
        Sample time of the controller (s).
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    poles
        The slowest vibrations at the first speed, tracked over the other speeds. After these vibrations, the tuple
        contains some that begin at a higher speed and are too strongly damped at first for a resonance. Such a
        vibration is included if, at the last speed, it has a resonance and a lower frequency than the fastest vibration
        tracked from the first speed.
    least_damped
        The vibration with the smallest damping ratio at any speed of the range, including speeds between those of the
        diagram. This vibration need not be one of `poles`. None if there are no vibrations.
    spectral_radii
        Largest modulus of the poles z (1), including drifts without vibration, at each speed, shape (n,). The loop is
        not stable where this modulus exceeds 1 (`amb_analysis.linear.stability`).
    growth_rates
        Growth rate of the pole with the largest modulus at each speed, ln|z|/T, shape (n,).
    least_stable
        The pole with the largest modulus at the worst speed of the range, which may lie between speeds of the diagram.
    unstable
        Speeds (rad/s) of the diagram at which the loop is not stable. If the loop is unstable only between these
        speeds, the worst speed is given.
    operating_speed
        Speed of the scenario (rad/s).
    limits
        Validity limits of the coefficients of seals.
    """

    name: ClassVar[str] = "poles"

    sample_time: Annotated[float, "s"]
    speeds: Annotated[Array, "rad/s"]
    poles: tuple[PoleOverSpeed, ...]
    least_damped: LeastDamped | None
    spectral_radii: Array
    growth_rates: Annotated[Array, "1/s"]
    least_stable: LoopStability
    unstable: Annotated[tuple[float, ...], "rad/s"]
    operating_speed: Annotated[float, "rad/s"]
    limits: Limits = ()

    @property
    def critical_speeds(self) -> tuple[CriticalCrossing, ...]:
        """Speeds at which a followed lateral vibration has the frequency of rotation, ascending.

        Axial vibrations are left out, because unbalance does not excite them.
        """
        return tuple(sorted(_crossings(self.speeds, self.poles), key=lambda crossing: crossing.speed))

    def text(self) -> list[TextBlock]:
        """Return a table of the poles at the lowest and highest speed, and lines about critical and unstable speeds."""
        unit, cycles = speed_unit(), frequency_unit()
        table = text_table(
            f"{self.rotor}: poles of the closed loop",
            (f"speed ({unit.label})", f"frequency ({cycles.label})", "damping ratio", "logarithmic decrement", "whirl"),
            left=("whirl",),
        )
        for k in (0, -1):
            for pole in self.poles:
                if pole.whirl[k] is not None:
                    frequency = cycles.number(pole.frequencies[k], 5)
                    shares = (number(pole.damping_ratios[k]), number(pole.decrements[k]))
                    table.add_row(
                        unit.number(self.speeds[k], 5),
                        frequency,
                        *shares,
                        (pole.whirl[k] or "") + self._mark(self.speeds[k]),
                    )
        criticals = ", ".join(
            f"{speed_unit().text(c.speed)} (mode {c.mode}, {c.whirl}, decrement {c.decrement:.3g}{self._mark(c.speed)})"
            for c in self.critical_speeds
        )
        notes = [*limit_notes(self.limits, self.speeds), *self.warning_lines()]
        answer, *details = self._verdict()
        return [answer, table, f"critical speeds: {criticals or 'none'}", *details, *notes]

    def _mark(self, speed: float) -> str:
        return f", {EXTRAPOLATED}" if is_extrapolated(self.limits, speed) else ""

    @property
    def unstable_ranges(self) -> tuple[tuple[float, float], ...]:
        """First and last speed (rad/s) of each range in which the loop is not stable."""
        speeds = np.unique([*self.speeds, *self.unstable])
        numbers = np.flatnonzero(np.isin(speeds, self.unstable))
        pieces = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1) if len(numbers) else []
        return tuple((float(speeds[piece[0]]), float(speeds[piece[-1]])) for piece in pieces)

    def _verdict(self) -> list[TextBlock]:
        worst = self.least_stable
        at = f"at {speed_unit().text(worst.speed)} {worst.motion}, |z| = {worst.radius:.7g}"
        notes = [worst.note] if worst.note else []
        if not self.unstable:
            up_to = f"{self.rotor} is stable up to {speed_unit().text(self.speeds[-1])}"
            return [f"{up_to}{self._least_damped()}", f"least stable: {at}", *notes]
        unit, pieces = speed_unit(), self.unstable_ranges
        ranges = [f"from {unit.number(a)} to {unit.text(b)}" if a < b else f"at {unit.text(a)}" for a, b in pieces]
        return [f"{self.rotor} is not stable {', '.join(ranges)}: {at}", *notes]

    def _least_damped(self) -> str:
        if self.least_damped is None:
            return ""
        return f"; least damped: at {speed_unit().text(self.least_damped.speed)} {self.least_damped}"


def poles(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | None = None,
    controller: FmuSource | PathLike[str] | None = None,
    up_to: Number | None = None,
    count: int = 8,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> ClosedLoopPoles:
    """Return the frequency, damping and whirl of the vibrations of a levitated rotor as functions of its spin speed.

    The result is the Campbell diagram of the levitated machine: s = ln(z) / T, where z is an eigenvalue of the sampled
    loop (`amb_cosim.linearise`). A vibration above half the sample rate is shown at the frequency of the rotor's mode,
    not at its alias.

    Parameters
    ----------
    scenario, rotor, controller
        The machine with its parameters, its rotor and its controller, as for `studies.inputs.controlled`.
    up_to
        Highest spin speed (rad/s), or a string with its unit; by default 1.5 times the speed of the scenario, or 628
        rad/s if the scenario's speed is 0.
    count
        Number of vibrations to follow from the lowest speed, the slowest first. Slow vibrations that begin at a higher
        speed, such as the precession of a gyroscopic rotor in damped bearings, are followed as well.
    set, flavour
        Parameter values by `component.variable`, as numbers or strings with units, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If a value is not allowed, or the scenario has no magnetic bearings under a controller.

    Examples
    --------
    >>> result = poles("compressor_levitated", count=2)
    >>> [f"{crossing.speed:.0f} rad/s" for crossing in result.critical_speeds]
    ['303 rad/s', '303 rad/s']
    """
    require(count >= 1, "count", count, "1 or more")
    chosen = controlled(scenario, rotor, controller)
    prepared = prepare_run(chosen.machine(), set, options=RunOptions(flavour=flavour))
    machine = Machine(prepared)
    loop = machine.loop
    highest = (1.5 * prepared.speed or DEFAULT_RANGE) if up_to is None else up_to
    speeds = speed_range(highest, POINTS)
    speeds[0] = LOWEST * speeds[-1]
    speeds = with_samples(speeds, machine.table_speeds)
    closer, all_vibrations = vibrations_over(loop, speeds)
    result = [of_speed for Omega, of_speed in zip(closer, all_vibrations, strict=True) if Omega in speeds]
    speeds, result, tracks = _about_crossings(loop, speeds, result, count)
    worst = max((of_speed.stability for of_speed in all_vibrations), key=lambda stability: stability.radius)
    stabilities = [of_speed.stability for of_speed in result]
    unstable = [stability.speed for stability in stabilities if not stability.is_stable]
    if not unstable and not worst.is_stable:
        unstable = [worst.speed]
    return ClosedLoopPoles(
        scenario=chosen.name,
        rotor=machine.rotor.name,
        sample_time=loop.sample_time,
        speeds=speeds,
        poles=tuple(_over_speed(result, track) for track in tracks),
        least_damped=least_damped(closer, all_vibrations),
        spectral_radii=np.array([stability.radius for stability in stabilities]),
        growth_rates=np.array([stability.growth_rate for stability in stabilities]),
        least_stable=worst,
        unstable=tuple(unstable),
        operating_speed=prepared.speed,
        limits=limits_of(machine.rotor.seals),
        warnings=prepared.warnings,
    )


def _about_crossings(
    loop: Loop, speeds: Array, result: list[Vibrations], count: int
) -> tuple[Array, list[Vibrations], list[list[int | None]]]:
    """Return speeds (rad/s), with some added close to each critical speed, their vibrations, and the tracks of these.

    The samples on both sides of a crossing are connected by a straight line. A speed is added where this line meets the
    synchronous line.
    """
    for _ in range(ROUNDS):
        tracks = _tracks(result, count)
        crossings = [c.speed for c in _crossings(speeds, [_over_speed(result, track) for track in tracks])]
        missing = [at for at in crossings if np.abs(speeds - at).min() > CLOSE * at]
        if not missing:
            break
        vibrations_at = dict(zip(speeds.tolist(), result, strict=True))
        speeds = with_samples(speeds, missing)
        result = [vibrations_at.get(Omega) or vibrations(loop, Omega) for Omega in speeds.tolist()]
    return speeds, result, _tracks(result, count)


def _tracks(result: list[Vibrations], count: int) -> list[list[int | None]]:
    """Return the tracks of the `count` slowest vibrations at the first speed, and of some that begin at a higher speed.

    Such a vibration is included if it is too strongly damped at its first speed for a resonance and, at the last speed,
    has a resonance and a lower frequency than the fastest of the `count` vibrations.
    """
    tracks, ratios = followed(result, count), result[-1].ratios()
    fastest = max((track[-1] for track in tracks if track[-1] is not None), default=-1)
    resonant = {k for k in range(fastest) if ratios[k] < RESONANT}  # numbers ascend with frequency
    later = begun_later(result, followed(result, len(result[0].poles)))
    return [*tracks, *(track for track in later if track[-1] in resonant and _begins_damped(result, track))]


def _begins_damped(result: list[Vibrations], track: list[int | None]) -> bool:
    first = next((at, k) for at, k in zip(result, track, strict=True) if k is not None)
    return bool(first[0].ratios()[first[1]] > RESONANT)


def _over_speed(vibrations: list[Vibrations], track: list[int | None]) -> PoleOverSpeed:
    pairs = list(zip(vibrations, track, strict=True))
    s = np.array([complex(np.nan, np.nan) if k is None else at.poles[k] for at, k in pairs])
    ratios = np.array([np.nan if k is None else at.ratios()[k] for at, k in pairs])
    whirl = tuple(None if k is None else whirl_of(float(at.senses[k])) for at, k in pairs)
    return PoleOverSpeed(s.imag, ratios, -2.0 * math.pi * s.real / s.imag, whirl)


def _crossings(speeds: Array, followed_poles: Sequence[PoleOverSpeed]) -> Iterator[CriticalCrossing]:
    for mode, pole in enumerate(followed_poles, start=1):
        if "axial" in pole.whirl:
            continue
        beyond = pole.frequencies - speeds
        before, after = beyond[:-1], beyond[1:]
        for k in np.flatnonzero(((before > 0.0) & (after <= 0.0)) | ((before <= 0.0) & (after > 0.0))):
            share = float(beyond[k] / (beyond[k] - beyond[k + 1]))
            at, decrement = ((1.0 - share) * v[k] + share * v[k + 1] for v in (speeds, pole.decrements))
            whirl = pole.whirl[k if share < 0.5 else k + 1] or "mixed"
            yield CriticalCrossing(mode, float(at), float(decrement), whirl)
