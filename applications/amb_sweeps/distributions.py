"""Distributions of the values of a sweep, for sampling (scipy.stats).

    normal(0.15 mm, 5 um) in 0.13 mm:0.17 mm     mean and standard deviation
    lognormal(0.12, 30 %) in 0.05:0.4            median m and coefficient of variation v
    triangular(0.05, 0.15, 0.4)                  least, most likely and largest value
    rayleigh(35 g.mm) in 0 g.mm:106 g.mm         mode
    @speeds.csv                                  a value per line, drawn with replacement

A lognormal value is m exp(s z), where z is a standard normal value and s^2 = ln(1 + v^2).

`in A:B` truncates a distribution F. Its value at the share p is F^-1(F(A) + p (F(B) - F(A))).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmi_export.building.units import to_unit

Quantity = tuple[float, str]  # a number and its unit, which may be empty


@dataclass(frozen=True)
class Family:
    """A kind of distribution: how it is written, and its parameters of scale, which must be positive."""

    form: str
    positive: tuple[int, ...]
    ordered: bool = False

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.form.count(",") + 1


FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        "normal": Family("normal(MEAN, STANDARD DEVIATION)", (1,)),
        "lognormal": Family("lognormal(MEDIAN, COEFFICIENT OF VARIATION)", (0, 1)),
        "triangular": Family("triangular(LEAST, MOST LIKELY, LARGEST)", (), ordered=True),
        "rayleigh": Family("rayleigh(MODE)", (0,)),
    }
)
_WRITTEN = re.compile(r"\s*([A-Za-z_]\w*)\s*\(([^()]*)\)\s*(?:in\s+([^:]*):([^:]*))?\s*")
_WIDTHS = (("normal", 1),)  # parameters that are differences, so that a unit with an offset only scales them


@dataclass(frozen=True)
class Distribution:
    """A distribution of a variable in `unit`; `quantiles` returns the values at shares between 0 and 1."""

    name: str
    quantiles: Callable[[NDArray[Any]], NDArray[Any]]
    unit: str = ""

    def at(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Return the values below which these shares of the distribution lie."""
        return tuple(float(value) for value in self.quantiles(np.asarray(shares, np.float64)))


def is_distribution(text: str) -> bool:
    """Return whether a text has the form of a distribution, of any family."""
    return _WRITTEN.fullmatch(text) is not None


def read_distribution(name: str, text: str, quantity: Callable[[str], Quantity | None]) -> Distribution:
    """Read a distribution of a variable, such as `normal(0.15 mm, 5 um) in 0.13 mm:0.17 mm`.

    Parameters
    ----------
    name
        Variable, for messages.
    text
        Family, parameters and limits. The first unit that is stated is the unit of the values.
    quantity
        Function that splits a text into number and unit; None if it has no number.

    Raises
    ------
    ValueError
        If the family, a parameter, a unit or the limits are not allowed.
    """
    match = _WRITTEN.fullmatch(text)
    family = FAMILIES.get(match[1]) if match else None
    if match is None or family is None:
        allowed = ", ".join(family.form for family in FAMILIES.values())
        raise ValueError(f"{name} = {text} is not allowed; a distribution is one of {allowed}, then in LEAST:LARGEST")
    written = [part.strip() for part in match[2].split(",")]
    parameters = [quantity(part) for part in written]
    if len(parameters) != family.count or None in parameters:
        raise ValueError(f"{name} = {text} is not allowed; write numbers, as in {family.form}")
    limits = [quantity(part) for part in match.groups()[2:] if part is not None]
    if None in limits:
        raise ValueError(f"{name} = {text} is not allowed; its limits must be numbers, as in 0.05:0.4")
    numbers = [entry for entry in parameters if entry is not None]
    ratio = numbers.pop() if match[1] == "lognormal" else None
    ends = [entry for entry in limits if entry is not None]
    unit = next((unit for _, unit in (*numbers, *ends) if unit), "")

    def number(entry: Quantity, is_width: bool = False) -> float:
        value, stated = entry
        if stated in ("", unit):
            return value
        zero = to_unit(f"0 {stated}", unit, name) if is_width else 0.0
        return to_unit(f"{value!r} {stated}", unit, name) - zero

    values = [number(entry, (match[1], k) in _WIDTHS) for k, entry in enumerate(numbers)]
    if ratio is not None:
        values.append(to_unit(f"{ratio[0]!r} {ratio[1]}", "1", name))
    low, high = [number(entry) for entry in ends] or (-math.inf, math.inf)
    for k in family.positive:
        if not 0.0 < values[k] < math.inf:
            of_parameter = re.split(r"[(,)]", family.form)[k + 1].strip().lower()
            raise ValueError(f"{name} = {text} is not allowed; its {of_parameter} is {written[k]} and must be above 0")
    if family.ordered and not (values == sorted(values) and values[0] < values[-1]):
        raise ValueError(f"{name} = {text} is not allowed; its values must ascend, as in {family.form}")
    return Distribution(name, _truncated(name, text, _frozen(match[1], values), low, high), unit)


def read_values(name: str, path: Path, quantity: Callable[[str], Quantity | None]) -> Distribution:
    """Read a file with a value per line; empty lines and lines that begin with # are skipped.

    Raises
    ------
    ValueError
        If the file cannot be read, has no value, or a line is not a finite number with an optional unit.
    """
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text"
        raise ValueError(f"{name}: the values in {path} cannot be read: {reason}") from error
    numbers: list[Quantity] = []
    for n, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        entry = quantity(line)
        if entry is None or not math.isfinite(entry[0]):
            raise ValueError(f"{name}: line {n} of {path} is {line.strip()[:40]!r}; each line must be a number")
        numbers.append(entry)
    if not numbers:
        raise ValueError(f"{name}: {path} has no values; each line must be a number")
    unit = next((unit for _, unit in numbers if unit), "")
    values = np.sort([v if stated in ("", unit) else to_unit(f"{v!r} {stated}", unit, name) for v, stated in numbers])
    return Distribution(
        name, lambda shares: values[np.minimum((shares * len(values)).astype(int), len(values) - 1)], unit
    )


def _frozen(family: str, values: Sequence[float]) -> Any:
    from scipy import stats

    if family == "normal":
        return stats.norm(values[0], values[1])
    if family == "lognormal":
        return stats.lognorm(math.sqrt(math.log1p(values[1] ** 2)), scale=values[0])
    if family == "triangular":
        low, mode, high = values
        return stats.triang((mode - low) / (high - low), low, high - low)
    return stats.rayleigh(scale=values[0])


def _truncated(name: str, text: str, law: Any, low: float, high: float) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Return the quantiles of a distribution within its limits.

    Above the median, the upper tail is used, because 1 - F loses digits there.
    """
    upper = low > float(law.median())
    first, last = (float(law.sf(v) if upper else law.cdf(v)) for v in (low, high))
    if not low < high or first == last:
        raise ValueError(f"{name} = {text} is not allowed; its limits must ascend and contain some of the distribution")
    inverse = law.isf if upper else law.ppf
    return lambda shares: np.clip(inverse(first + shares * (last - first)), low, high)
