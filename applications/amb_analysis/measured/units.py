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
STANDARD_GRAVITY = 9.80665  # m/s^2
UNEVEN = 1e-6  # largest deviation of a step from the mean, relative


@dataclass(frozen=True)
class StatedUnits:
    """Units that the user states, in place of those of a file, by the names of its columns or channels."""

    units: Mapping[str, str] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def of(self, name: str, unit: str) -> str:
        """Return the stated unit of a column or channel; without one, the unit in the file."""
        self.names.add(name)
        return self.units.get(name, unit)

    def check(self) -> None:
        """Refuse a unit that belongs to no name in the file.

        Raises
        ------
        ValueError
            If there is one.
        """
        for name, unit in self.units.items():
            if name not in self.names:
                raise ValueError(f"unit {name} = {unit} is not used; {suggest(name, sorted(self.names))}")


def factor_to(target: str, unit: str, name: str) -> float:
    """Return the factor from a unit to another one, such as `Hz`.

    Raises
    ------
    ValueError
        If it is missing, or a unit of something else.
    """
    _require_unit(unit, name, target)
    return to_unit(f"1 {unit}", target, name)


def si_unit(unit: str, name: str) -> tuple[float, str]:
    """Return the factor from a unit to its SI unit, and that unit; `g` is the standard acceleration of gravity.

    Raises
    ------
    ValueError
        If it is missing, or not a unit of displacement, velocity, acceleration, force, current, voltage or speed.
    """
    _require_unit(unit, name, "m/s2")
    text = unit.strip()
    if text in ("1", "-"):
        return 1.0, "1"
    if text in ("g", "G", "gn", "g_n"):
        return STANDARD_GRAVITY, "m/s2"
    for target in SI:
        try:
            return to_unit(f"1 {text}", target, name), target
        except ValueError:
            continue
    raise ValueError(f"{name}: unit {unit!r} is not allowed; it must be one of {', '.join(SI)}, g, or a multiple")


def si_channel(name: str, unit: str) -> tuple[float, Channel]:
    """Return the factor from a unit to its SI unit, and the channel in that unit; see `si_unit` for errors."""
    factor, si = si_unit(unit, name)
    return factor, Channel(name, si)


def even_step(times: Array) -> float:
    """Return the step of evenly spaced times (s).

    Raises
    ------
    ValueError
        If they are not evenly spaced.
    """
    steps = np.diff(times)
    step = float(np.mean(steps)) if len(steps) else 0.0
    if not step > 0.0 or not np.isfinite(times).all() or np.abs(steps - step).max() > UNEVEN * step + 1e-12:
        raise ValueError("its times are not evenly spaced; resample the record")
    return step


def split_quotient(unit: str, name: str) -> tuple[str, str]:
    """Return the units of output and input of a response's unit, `m/N` or `(m/s2)/N`.

    Raises
    ------
    ValueError
        If it is not a quotient.
    """
    _require_unit(unit, name, "m/N")
    above, slash, below = unit.strip().rpartition("/")
    if not slash:
        raise ValueError(f"{name}: unit {unit!r} is not allowed; it must be that of output over input, such as m/N")
    return above.strip().removeprefix("(").removesuffix(")"), below.strip()


def _require_unit(unit: str, name: str, example: str) -> None:
    if not unit.strip():
        raise ValueError(f"{name} has no unit; write it into the file, or state it: --channel-unit '{name}={example}'")
