"""Units of figures, tables and pages: by default rpm for speeds, Hz for frequencies, and other units by magnitude.

Figures, tables and pages all use this module, so one choice applies to a whole command or notebook.
"""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from amb_cosim.presentation.digits import significant, with_micro_signs
from amb_files.checks import require_kind
from array_types import Array

SIZES = {  # in the quantity's SI unit, which comes first; frequencies are speeds, 1 Hz is a turn per s
    "speed": {"rad/s": 1.0, "Hz": 2.0 * math.pi, "rpm": 2.0 * math.pi / 60.0},
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "force": {"N": 1.0, "kN": 1e3},
}
ZERO_CELSIUS = 273.15  # K
QUANTITIES = {name: quantity for quantity, sizes in SIZES.items() for name in sizes}
SYMBOLS = {"rad/s": r"$\Omega$ (rad/s)", "Hz": r"$\Omega/2\pi$ (Hz)", "rpm": r"$n$ (rpm)"}  # of the spin speed
LENGTH_IN_UM, FORCE_IN_KN = 1e-4, 1e3  # m, below which lengths are in um; N, from which on forces are in kN


class _Choice(threading.local):
    """The unit that a thread has chosen for each quantity; a new thread has chosen none."""

    def __init__(self) -> None:
        self.units: dict[str, str] = {}


_choice = _Choice()
_OTHER_NAMES = {"1/min": "rpm", "\N{MICRO SIGN}m": "um"}  # of the same unit
_LABEL = re.compile(r"^(.*\()?([^()]*)(\))?$")
_NAMES = "|".join(map(re.escape, [*_OTHER_NAMES, *QUANTITIES]))
_NUMBER = r"(-?\d[\d.]*(?:e[-+]?\d+)?)"
_SPEEDS = re.compile(rf"(?<![\w.]){_NUMBER}(?: to {_NUMBER})? rad/s(?![\w/^])")
_CELL = re.compile(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?(?![\w.])")  # a number in a cell of a table
_GROUPED = r"(-?(?:\d{1,3}(?:,\d{3})+|\d[\d.]*)(?:e[-+]?\d+)?)"  # as 12,000
_VALUE = re.compile(rf"(?<![\w.]){_GROUPED}(?:( to |-){_GROUPED})? ({_NAMES})(?![\w/^]|\.\w)")
_PLACE = re.compile(r"\bz = $")  # before a position along the shaft


@dataclass(frozen=True)
class ShownUnit:
    """A display unit: its name, and its size in the SI unit."""

    name: str
    size: float

    @property
    def label(self) -> str:
        """The printed unit."""
        return with_micro_signs(self.name)

    def of(self, values: ArrayLike) -> Array:
        """Convert values from the SI unit to this one."""
        return np.asarray(values, np.float64) / self.size

    def of_hertz(self, values: ArrayLike) -> Array:
        """Convert frequencies from Hz to this unit of speeds."""
        return self.of(SIZES["speed"]["Hz"] * np.asarray(values, np.float64))

    def text(self, value: float, digits: int = 4) -> str:
        """Convert a value from the SI unit to this one, and write it with the name of the unit."""
        return f"{self.number(value, digits)} {self.label}"

    def number(self, value: float, digits: int = 4) -> str:
        """Convert a value from the SI unit to this one, and write it with `significant` digits."""
        return significant(value / self.size, digits)


class units:  # used as a function, and in `with`
    """Choose the units of figures and tables from now on, or within `with`: `units("rpm", "um")`, `units("rpm,um,kN")`.

    The choice holds in the thread that makes it.

    Parameters
    ----------
    names
        `rad/s`, `Hz` or `rpm` for speeds and frequencies, `mm`, `um` or `m` for lengths, `N` or `kN` for forces. A
        quantity for which no unit is named keeps its default: rpm for speeds, Hz for frequencies, and a unit that suits
        the values for lengths and forces.

    Raises
    ------
    ValueError
        If a name is unknown, or two units belong to the same quantity.

    Examples
    --------
    >>> with units("rad/s"):
    ...     speed_unit().name
    'rad/s'
    >>> speed_unit().name
    'rpm'
    """

    def __init__(self, *names: str) -> None:
        for name in names:
            require_kind("units", name, str, "names, such as units('rpm', 'um')")
        chosen = parse_units(",".join(names))
        self._before = _choice.units
        _choice.units = chosen

    def __enter__(self) -> None:
        """Keep the choice until the end of the block."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _choice.units = self._before


def parse_units(text: str) -> dict[str, str]:
    """Return the unit of each quantity according to a text such as `rpm,um,kN`.

    Raises
    ------
    ValueError
        If a name is not a display unit, or two units belong to the same quantity.
    """
    result: dict[str, str] = {}
    for name in filter(None, re.split(r"[,;\s]+", text.replace("\N{MICRO SIGN}", "u"))):
        if name not in QUANTITIES:
            raise ValueError(f"units = {name!r} is not allowed; it must be one of {', '.join(QUANTITIES)}")
        quantity = QUANTITIES[name]
        if quantity in result:
            raise ValueError(f"units = {text!r} is not allowed; it must have only one unit of {quantity}")
        result[quantity] = name
    return result


def speed_unit(usual: str = "rpm") -> ShownUnit:
    """Return the unit of speeds, and of frequencies plotted over speeds: the usual one unless another was chosen."""
    return _unit("speed", usual)


def frequency_unit() -> ShownUnit:
    """Return the unit of frequencies: Hz unless a unit of speeds was chosen."""
    return speed_unit("Hz")


def frequency_label() -> str:
    """Return the label of an axis of frequencies."""
    return f"frequency ({frequency_unit().label})"


def frequency_text(hertz: float, digits: int = 4) -> str:
    """Return a frequency (Hz) as a text in the unit of frequencies, followed by the name of this unit."""
    return frequency_unit().text(SIZES["speed"]["Hz"] * hertz, digits)


def length_unit(largest: float) -> ShownUnit:
    """Return the unit for lengths up to `largest` (m): um below 0.1 mm, otherwise mm, unless a unit was chosen."""
    return _unit("length", "um" if largest < LENGTH_IN_UM else "mm")


def force_unit(largest: float) -> ShownUnit:
    """Return the unit for forces up to `largest` (N): kN from 1 kN on, otherwise N, unless a unit was chosen."""
    return _unit("force", "kN" if largest >= FORCE_IN_KN else "N")


def temperature_text(kelvin: float) -> str:
    """Return a temperature (K) in °C."""
    return f"{significant(kelvin - ZERO_CELSIUS)} °C"


def relabelled(label: str, *quantities: str) -> tuple[str, float]:
    """Return the label of an axis with its unit replaced by the chosen one, and the factor for the axis's values.

    A label is a unit, or ends with a unit in brackets. If no unit was chosen for its quantity, the label is returned
    unchanged with the factor 1.
    """
    parts = _LABEL.match(label)
    head, name, tail = parts.groups("") if parts else ("", label, "")
    unit = chosen_for(name)
    if unit is None or QUANTITIES[unit.name] not in quantities:
        return label, 1.0
    return f"{head}{unit.label}{tail}", _size(name) / unit.size


def column_in_chosen_units(heading: str) -> tuple[str, Callable[[str], str]]:
    """Return the heading of a table's column with the chosen unit, and the function that converts the column's cells.

    Cells of a column without a unit may be texts with units. Places along the shaft keep their unit, and so does a
    column with two quantities.

    Examples
    --------
    >>> with units("kN"):
    ...     heading, convert = column_in_chosen_units("forces (N)")
    >>> heading, convert("1481, 785.3")
    ('forces (kN)', '1.481, 0.7853')
    """
    stays = is_place(heading) or heading.count("(") > 1
    label, factor = (heading, 1.0) if stays else relabelled(heading, *SIZES)
    if factor == 1.0:
        return convert_units_in_text(label), convert_units_in_text
    return label, lambda cell: _CELL.sub(lambda found: significant(float(found[0]) * factor, 4), cell)


def is_place(label: str) -> bool:
    """Return whether a label names a place along the shaft, which keeps its unit."""
    return label.startswith("z ") or label.endswith("(m)")


def convert_units_in_text(text: str) -> str:
    """Return a text in which each number with a unit, and each range, is converted to the chosen unit.

    Places along the shaft keep their unit.

    Examples
    --------
    >>> with units("Hz"):
    ...     convert_units_in_text("9,600 to 12,000 rpm, and at rest above 104.72 rad/s")
    '160 to 200 Hz, and at rest above 16.67 Hz'
    """

    def value(match: re.Match[str]) -> str:
        first, between, last, name = match.groups("")
        unit = chosen_for(name)
        if unit is None or unit.size == _size(name) or _PLACE.search(text, 0, match.start()):
            return match[0]
        numbers = (unit.number(float(number.replace(",", "")) * _size(name)) for number in (first, last) if number)
        return f"{between.join(numbers)} {unit.label}"

    return _VALUE.sub(value, text) if _choice.units else text


def with_speeds_in(text: str, unit: ShownUnit) -> str:
    """Return a text in which speeds in rad/s, and ranges of them, are converted to another unit.

    Examples
    --------
    >>> with_speeds_in("a whirl of -628.319 to -62.8319 rad/s", frequency_unit())
    'a whirl of -100 to -10 Hz'
    """

    def value(match: re.Match[str]) -> str:
        return " to ".join(unit.number(float(number)) for number in match.groups() if number) + f" {unit.label}"

    return _SPEEDS.sub(value, text)


def chosen_for(name: str) -> ShownUnit | None:
    """Return the unit that was chosen for the quantity that the unit `name` measures, or None if none was chosen."""
    quantity = QUANTITIES.get(_OTHER_NAMES.get(name, name), "")
    return _unit(quantity, "") if quantity in _choice.units else None


def spin_label() -> str:
    """Return the label of an axis of spin speeds."""
    return f"spin speed {SYMBOLS[speed_unit().name]}"


def spin_text(*speeds: float) -> str:
    """Return one spin speed (rad/s), or the first and last of several, as text for a title."""
    unit = speed_unit()
    symbol = SYMBOLS[unit.name].partition(" ")[0]
    return f"{symbol} = {' to '.join(map(unit.number, speeds))} {unit.label}"


def _size(name: str) -> float:
    name = _OTHER_NAMES.get(name, name)
    return SIZES[QUANTITIES[name]][name]


def _unit(quantity: str, usual: str) -> ShownUnit:
    name = _choice.units.get(quantity) or usual
    return ShownUnit(name, SIZES[quantity][name])
