"""Variations of a sweep: axes with labelled values; each value sets variables of a scenario.

    Omega=60:300 rad/s:60                             sixty speeds, which need a unit
    rotor_contact.impeller.u=1 g.m:60 g.m:40          with a unit
    trip.rotor_contact.impeller.u=10 g.m,20 g.m       a list; set by the event labelled `trip`
    Omega=60:300 rad/s:3 & rotor_contact.impeller.u=3 g.m,2 g.m,1 g.m    varied together
    trip.cycle=5:6:16                                 when the event happens
    unbalance_factor=1,1.25                           a field of the scenario
    fmu.rolac_controller=first.fmu,second.fmu         another FMU for a component
    scenario=first.toml,second.toml                   other scenarios
    control=@controls.toml                            a table of settings for each label

A range without a count, `60:300`, is for sampling; so are distributions and files of values (see `distributions`):

    rotor_contact.*.clearance=normal(0.15 mm, 5 um) in 0.13 mm:0.17 mm
    Omega=@speeds.csv                                 a value per line
    a.mu=0.1:0.4 & b.mu=normal(0.2, 0.05)             one share for both, so that they rise together
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from amb_cosim.scenario.scenario import SPEED
from amb_files.checks import repeated, require_kind
from amb_files.plain_values import Plain, listed, plain_value, plain_values
from amb_sweeps.distributions import Distribution, is_distribution, read_distribution, read_values
from fmi_export.building.units import to_unit

MOST_POINTS = 10_000_000  # points of a sweep
FEW, ROUNDING = 12, 4e-16  # significant digits that a user would write, and relative rounding of a conversion
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?![-+.\d]).*?)\s*")
_NUMBER, _TO = r"\d+(?:\.\d+)?", r" *(?:-|–|\.\.+|to) *"
_SPAN = re.compile(rf"{_NUMBER}(?:{_TO}{_NUMBER}(?: .*|[^.\s]*)| *(\S.*?){_TO}{_NUMBER} *\1)")  # such as 200-300
_NAME = re.compile(r"[A-Za-z_][\w?*\[\]]*(?:\.[^&/]+)?")  # variables of FMUs have any names, such as der(x)
_VARIED = re.compile(r"\s*(.*?\S)\s*=\s*(@.*\S|[^=]*[^=\s])\s*")  # values have no =, paths of files may

Settings = Mapping[str, Plain]
Vary = Mapping[str, Any]  # names, or several joined by "&", with their values


def is_moment(name: str) -> bool:
    """Return whether a variation is the moment of an event, `LABEL.cycle` or `LABEL.time`."""
    return re.fullmatch(r"[^.]+\.(cycle|time)", name) is not None


def is_phase(name: str) -> bool:
    """Return whether a variation is periodic with the rotor's revolution, like the cycle of an event."""
    return is_moment(name) and name.endswith(".cycle")


@dataclass(frozen=True)
class Column:
    """Values of one variable along an axis: numbers in `unit` (if empty, in the variable's unit), or texts."""

    name: str
    values: tuple[Plain, ...]
    unit: str = ""

    @property
    def numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in self.values)

    def setting(self, k: int) -> Plain:
        """Return the k-th value as a setting."""
        value = self.values[k]
        return f"{value!r} {self.unit}" if self.unit and not isinstance(value, str) else value


@dataclass(frozen=True)
class Axis:
    """A dimension of a sweep: columns that are varied together, or alternatives with a table of settings each."""

    name: str
    columns: tuple[Column, ...]
    alternatives: tuple[Settings, ...] = ()

    def __len__(self) -> int:
        return len(self.columns[0].values)

    def settings(self, k: int) -> dict[str, Plain]:
        """Return the settings of the k-th value."""
        if self.alternatives:
            return dict(self.alternatives[k])
        return {column.name: column.setting(k) for column in self.columns}


@dataclass(frozen=True)
class Range:
    """A range from `start` to `stop` in `unit`, for sampling."""

    name: str
    start: float
    stop: float
    unit: str = ""

    def at(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Return the values at these fractions of the range."""
        return tuple(self.start + float(s) * (self.stop - self.start) for s in shares)


Sampled = Range | Distribution
Variation = Axis | tuple[Sampled, ...]


def read_variations(vary: Vary) -> list[Variation]:
    """Read the variations.

    Parameters
    ----------
    vary
        The variation of each name: a text as in a `--vary` option, a sequence of values, or a table of settings for
        each label. For names joined by `&`, each name has its own sequence of values.

    Raises
    ------
    ValueError
        If a text is invalid, a name is varied twice, or values that are varied together differ in number.
    """
    require_kind("vary", vary, Mapping, "a table with the values of each name")
    variations = [_variation(name, values) for name, values in vary.items()]
    if duplicates := repeated(name for variation in variations for name in names_of(variation)):
        raise ValueError(f"{', '.join(sorted(duplicates))} is varied twice; it may be varied once")
    if not variations:
        raise ValueError("nothing is varied; `vary` must have a name with START:STOP:COUNT or VALUE,VALUE,...")
    return variations


def parse_vary(texts: Sequence[str]) -> dict[str, Any]:
    """Read `--vary` options into the mapping that `read_variations` takes."""
    vary: dict[str, Any] = {}
    for text in texts:
        parts = [match.groups() for item in text.split("&") if (match := _VARIED.fullmatch(item))]
        if len(parts) <= text.count("&"):
            raise ValueError(f"{text!r} varies nothing; write NAME=START:STOP:COUNT or NAME=VALUE,VALUE,...")
        name = " & ".join(name for name, _ in parts)
        if name in vary:
            raise ValueError(f"{name} is varied twice; it may be varied once")
        vary[name] = [value for _, value in parts] if len(parts) > 1 else parts[0][1]
    return vary


def names_of(variation: Variation) -> list[str]:
    """Return the name of an axis, and the names of its columns."""
    if isinstance(variation, Axis):
        return list(dict.fromkeys([variation.name, *(column.name for column in variation.columns)]))
    return [part.name for part in variation]


def _variation(name: str, values: Any) -> Variation:
    names = [part.strip() for part in name.split("&")]
    for item in names:
        if not _NAME.fullmatch(item):
            raise ValueError(f"{item!r} is not a variable name; write for example Omega or rotor_contact.impeller.u")
    if isinstance(values, str) and values.startswith("@") and not _is_file_of_values(values):
        values = _table(values[1:])
    if isinstance(values, Mapping):
        return _alternatives(name, values)
    if len(names) == 1:
        part = _values(name, values)
        return Axis(name, (part,)) if isinstance(part, Column) else (part,)
    if isinstance(values, str) or len(values) != len(names):
        raise ValueError(f"{name} needs values for each of its {len(names)} names")
    parts = [_values(item, of_name) for item, of_name in zip(names, values, strict=True)]
    columns = [part for part in parts if isinstance(part, Column)]
    if not columns:
        return tuple(part for part in parts if not isinstance(part, Column))
    sizes = {column.name: len(column.values) for column in columns}
    if len(columns) < len(parts) or len(set(sizes.values())) > 1:
        counts = ", ".join(f"{column} {n}" for column, n in sizes.items())
        raise ValueError(f"{name}: variables varied together need equal numbers of values: {counts}")
    return Axis(names[0], tuple(columns))


def _alternatives(name: str, tables: Mapping[str, Any]) -> Axis:
    if not tables or not all(isinstance(table, Mapping) for table in tables.values()):
        raise ValueError(f"{name}: each label needs a table of settings, such as PID.'rolac_controller.rolac_enable'")
    return Axis(
        name,
        (Column(name, tuple(str(label) for label in tables)),),
        tuple(plain_values(table, name) for table in tables.values()),
    )


def _table(path: str) -> dict[str, Any]:
    from amb_files.toml import read_toml

    return read_toml(Path(path), f"table {path}")


def _is_file_of_values(text: str) -> bool:
    return text.startswith("@") and Path(text[1:]).suffix.lower() in (".csv", ".txt")


def _values(name: str, values: Any) -> Column | Sampled:
    if isinstance(values, str) and (is_distribution(values) or _is_file_of_values(values)):
        if name == "scenario" or name.startswith("fmu."):
            raise ValueError(f"{name} = {values} is not allowed; {name} has no numbers, so list its values")
        read = read_distribution(name, values, _quantity) if is_distribution(values) else None
        part = read or read_values(name, Path(values[1:].strip()), _quantity)
        if not part.unit:
            _require_speed_unit(name, values)
        return part
    if isinstance(values, str):
        first, colon, _ = values.partition(":")
        is_range = bool(colon) and ("/" not in values or _quantity(first) is not None)  # texts with a slash are paths
        return _range(name, values) if is_range else _list(name, values.split(","))
    return _list(name, [plain_value(value, name) for value in listed(values)])


def _range(name: str, text: str) -> Column | Range:
    parts = [part.strip() for part in text.split(":")]
    ends = [_quantity(part) for part in parts[:2]]
    if len(parts) not in (2, 3) or None in ends:
        raise ValueError(f"{name} = {text} is not a range; write START:STOP:COUNT, such as 1 g.m:60 g.m:40")
    (start, first), (stop, last) = (end for end in ends if end is not None)
    unit = last or first
    if first != last and first and last:
        start = _converted(start, first, unit, name)
    if not unit and (start or stop):
        _require_speed_unit(name, text)
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise ValueError(f"{name} = {text} is not allowed; its ends must be finite numbers")
    if len(parts) == 2:
        return Range(name, start, stop, unit)
    if not parts[2].isdecimal() or not 1 <= int(parts[2]) <= MOST_POINTS:
        raise ValueError(f"{name} = {text}: a count of {parts[2]!r} is not allowed; it must be 1 to {MOST_POINTS}")
    return Column(name, _evenly(start, stop, int(parts[2])), unit)


def _evenly(start: float, stop: float, count: int) -> tuple[float, ...]:
    """Return evenly spaced numbers from `start` to `stop`: those that a user would write, 0.3 between 0.1 and 0.5.

    Both ends stand for their shortest decimals. Each number is the fraction of integers between them, rounded once.
    """
    first, last = Fraction(repr(start)), Fraction(repr(stop))
    below = first.denominator * last.denominator * max(count - 1, 1)
    begin, step = int(first * below), int((last - first) * below) // max(count - 1, 1)
    return tuple((begin + k * step) / below for k in range(count))


def _converted(value: float, unit: str, to: str, name: str) -> float:
    """Return a number in another unit; a user's number of a few digits if it differs from that by rounding only."""
    result = to_unit(f"{value!r} {unit}", to, name)
    short = float(f"{result:.{FEW}g}")
    return short if math.isclose(result, short, rel_tol=ROUNDING, abs_tol=0.0) else result


def _list(name: str, values: Sequence[Any]) -> Column:
    """Return a column: numbers in the first unit that is stated, if all values are numbers; otherwise texts."""
    items = [item.strip() if isinstance(item, str) else item for item in values]
    invalid = [item for item in items if not isinstance(item, bool | int | float | str) or item == ""]
    if invalid or not items:
        raise ValueError(f"{name} = {values} is not allowed; it must be a list of numbers or of texts")
    spans = [item for item in items if isinstance(item, str) and _SPAN.fullmatch(item)]
    if spans:
        raise ValueError(f"{name} = {spans[0]} is not a value; write a range as START:STOP:COUNT, such as 200:300:11")
    quantities = [_quantity(item) if isinstance(item, str) else None for item in items]
    numbers = [entry for entry in quantities if entry is not None]
    if len(numbers) == len(items):
        units = [unit for _, unit in numbers if unit]
        unit = units[0] if units else ""
        if not unit and any(v for v, _ in numbers) and any(isinstance(item, str) for item in items):
            _require_speed_unit(name, ",".join(map(str, items)))
        converted = (v if u in ("", unit) else _converted(v, u, unit, name) for v, u in numbers)
        return Column(name, tuple(converted), unit)
    return Column(name, tuple(items))


def is_speed(name: str) -> bool:
    """Return whether a variation is the spin speed of a scenario."""
    return name.rpartition(".")[2] == SPEED


def _require_speed_unit(name: str, text: str) -> None:
    """Refuse speeds that are given as texts without a unit; Python numbers are in rad/s."""
    if is_speed(name):
        raise ValueError(f"{name} = {text} has no unit; write it after a value, such as 60 rpm or 60 rad/s")


def _quantity(text: str) -> tuple[float, str] | None:
    match = _QUANTITY.fullmatch(text)
    return (float(match[1]), match[2]) if match else None
