"""SI units and sample times of measured channels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from amb_analysis.measured.records import Channel
from amb_files.suggestions import suggest
from array_types import Array
from fmi_export.building.units import to_unit

SI = ("m", "m/s", "m/s2", "N", "A", "V", "rad/s", "1")
UNEVEN = 1e-6  # largest deviation of times from a straight line, in steps, but for their rounding
MOST_DIGITS = 12  # significant digits to which times may have been rounded
SHARE = 1.05  # of a rounding unit, by which times may deviate from a straight line: they may be cut, not rounded
FINE = 0.4  # of a step, up to which a rounding unit shows whether a sample is missing
SINGLE = 1e-8  # relative difference of a number of single precision from its text of nine digits


@dataclass(frozen=True)
class StatedUnits:
    """Units that the user states, by the names of a file's columns or channels; they replace the units in the file."""

    units: Mapping[str, str] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def of(self, name: str, unit: str) -> str:
        """Return the stated unit of a column or channel, or the unit in the file if the user states no unit."""
        self.names.add(name)
        return self.units.get(name, unit)

    def check(self) -> None:
        """Refuse a stated unit whose name does not occur in the file.

        Raises
        ------
        ValueError
            If the file does not contain the name of a stated unit.
        """
        for name, unit in self.units.items():
            if name not in self.names:
                raise ValueError(f"unit {name} = {unit} is not used; {suggest(name, sorted(self.names))}")


def factor_to(target: str, unit: str, name: str) -> float:
    """Return the factor that converts a unit to the unit `target`, such as `Hz`.

    Raises
    ------
    ValueError
        If the unit is missing or is a unit of another quantity.
    """
    _require_unit(unit, name, target)
    return to_unit(f"1 {unit}", target, name)


def si_unit(unit: str, name: str) -> tuple[float, str]:
    """Return the factor from a unit to its SI unit, and that unit; `g` is the standard acceleration of gravity.

    Raises
    ------
    ValueError
        If the unit is missing or is not a unit of displacement, velocity, acceleration, force, current, voltage or
        speed.
    """
    _require_unit(unit, name, "m/s2")
    text = unit.strip()
    if text in ("1", "-"):
        return 1.0, "1"
    for target in SI:
        try:
            return to_unit(f"1 {text}", target, name), target
        except ValueError:
            continue
    allowed = f"{', '.join(SI)}, g, or a multiple of one of these"
    raise ValueError(f"{name}: unit {unit!r} is not allowed; it must be one of {allowed}")


def si_channel(name: str, unit: str) -> tuple[float, Channel]:
    """Return the factor from a unit to its SI unit, and the channel in that unit; see `si_unit` for errors."""
    factor, si = si_unit(unit, name)
    return factor, Channel(name, si)


def even_step(times: Array) -> float:
    """Return the step of evenly spaced times, in their unit.

    The step is the slope h of the straight line t_0 + k h that fits the times by least squares. Times are evenly spaced
    if they deviate from this line only by rounding: to decimal places or significant digits, as in a file, or to single
    precision.

    Raises
    ------
    ValueError
        If the times are not evenly spaced, or not finite.
    """
    if len(times) < 2 or not np.isfinite(times).all():
        raise ValueError(f"its {len(times)} times are not allowed; there must be two or more finite numbers")
    k = np.arange(len(times)) - 0.5 * (len(times) - 1)
    centred = times - times[0]
    centred = centred - np.mean(centred)
    step = float(k @ centred / (k @ k))
    errors = np.abs(centred - step * k)
    if not step > 0.0 or errors.max() > UNEVEN * step + SHARE * _rounding(times, FINE * step):
        worst = int(np.argmax(errors))
        raise ValueError(
            f"its times are not evenly spaced: sample {worst + 1}, at {times[worst]:.9g}, is off by {errors[worst]:.3g}"
            f", and the step is {step:.6g}; write times with more digits, or resample an uneven record"
        )
    return step


def _rounding(times: Array, most: float) -> float:
    """Return the largest unit, up to `most`, to which all times are rounded, in decimal or in binary digits."""
    largest = float(np.abs(times).max())
    units = [float(np.spacing(largest))]
    if (np.abs(times - times.astype(np.float32)) <= SINGLE * np.abs(times)).all():
        units.append(float(np.spacing(np.float32(largest))))
    for digits in range(1, MOST_DIGITS + 1):
        unit = 10.0 ** (np.floor(np.log10(largest)) + 1 - digits) if largest > 0.0 else 0.0
        decimals = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(times), 1e-300))) + 1 - digits)
        if unit <= most and np.allclose(np.round(times / decimals) * decimals, times, rtol=1e-13, atol=0.0):
            units.append(unit)
            break
    return max((unit for unit in units if unit <= most), default=0.0)


def split_quotient(unit: str, name: str) -> tuple[str, str]:
    """Return the units of output and input from a response's unit, such as `m/N` or `(m/s2)/N`.

    Raises
    ------
    ValueError
        If the unit is not a quotient.
    """
    _require_unit(unit, name, "m/N")
    above, slash, below = unit.strip().rpartition("/")
    if not slash:
        raise ValueError(f"{name}: unit {unit!r} is not allowed; it must be a unit of output over input, such as m/N")
    return above.strip().removeprefix("(").removesuffix(")"), below.strip()


def _require_unit(unit: str, name: str, example: str) -> None:
    if not unit.strip():
        raise ValueError(
            f"{name} has no unit; write it into the file, or state it with channel_units={{'{name}': '{example}'}}"
        )
