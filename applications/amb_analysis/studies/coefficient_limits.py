"""Validity limits of the coefficients of bearings and seals, and notes on results beyond these limits.

A table of coefficients over the spin speed has a lowest and a highest speed. Outside this range, the coefficients at
the nearest speed are used. If coefficients of an imported part depend on the whirl frequency, their values at one
frequency are used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

from amb_cosim.presentation.units import frequency_unit, speed_unit
from array_types import Array
from rotor_analysis.parts import Bearing

EXTRAPOLATED = "extrapolated"  # mark of a result at a speed outside a table


@dataclass(frozen=True)
class CoefficientLimits:
    """Validity limits that the coefficients of some bearings and seals share.

    parts
        Names of these bearings and seals.
    lowest, highest
        First and last spin speed (rad/s) of their tables; None for constant coefficients.
    whirl_frequency
        Whirl frequency (rad/s) at which the coefficients were evaluated; None if they do not depend on it.
    """

    parts: tuple[str, ...]
    lowest: Annotated[float | None, "rad/s"]
    highest: Annotated[float | None, "rad/s"]
    whirl_frequency: Annotated[float | None, "rad/s"]

    def cover(self, Omega: float) -> bool:
        """Return whether a spin speed (rad/s) is within the tables."""
        return self.lowest is None or self.highest is None or self.lowest <= Omega <= self.highest


Limits = tuple[CoefficientLimits, ...]


def limits_of(parts: Iterable[Bearing]) -> Limits:
    """Return the validity limits of bearings and seals; parts with the same limits form a group."""
    groups: dict[tuple[float | None, float | None, float | None], list[str]] = {}
    for part in parts:
        ends = (part.at_speed[0].speed, part.at_speed[-1].speed) if part.at_speed else (None, None)
        if part.at_speed or part.whirl_frequency is not None:
            groups.setdefault((*ends, part.whirl_frequency), []).append(part.name)
    return tuple(CoefficientLimits(tuple(names), *limits) for limits, names in groups.items())


def is_extrapolated(limits: Limits, Omega: float) -> bool:
    """Return whether a spin speed (rad/s) is outside a table, so that the coefficients at its end are used."""
    return not all(group.cover(Omega) for group in limits)


def covered_speeds(limits: Limits) -> tuple[float, float]:
    """Return the first and last speed (rad/s) that all tables cover; last < first if tables do not overlap."""
    lowest = max((group.lowest for group in limits if group.lowest is not None), default=-math.inf)
    highest = min((group.highest for group in limits if group.highest is not None), default=math.inf)
    return lowest, highest


def limit_notes(limits: Limits, speeds: Iterable[float] | Array) -> list[str]:
    """Return sentences about tables that do not cover all of the speeds (rad/s), and about frozen coefficients."""
    unit, speeds = speed_unit(), [float(Omega) for Omega in speeds]
    notes = []
    for group in limits:
        names = ", ".join(group.parts)
        if group.lowest is not None and group.highest is not None and not all(map(group.cover, speeds)):
            ends = f"{unit.number(group.lowest)} to {unit.text(group.highest)}"
            notes.append(
                f"{names}: coefficients from {ends}; elsewhere, coefficients of the nearest speed ({EXTRAPOLATED})"
            )
        if group.whirl_frequency is not None:
            notes.append(f"{names}: {frozen_at(group.whirl_frequency)}; modes at other frequencies are less accurate")
    return notes


def frozen_at(frequency: float) -> str:
    """Return a clause that states the whirl frequency (rad/s) at which coefficients are frozen."""
    return f"coefficients are those at a whirl frequency of {frequency_unit().text(frequency)}"
