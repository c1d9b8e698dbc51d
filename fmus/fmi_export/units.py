"""Units: FMI base-unit exponents and conversions, by pint."""

from __future__ import annotations

import math
import re
from functools import cache

import pint

SI = ("kg", "m", "s", "A", "K", "mol", "cd")
_PINT_NAMES = dict(
    zip(("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela"), SI, strict=True)
)


@cache
def registry() -> pint.UnitRegistry:  # type: ignore[type-arg]
    return pint.UnitRegistry()


def parse_unit(unit: str) -> pint.Unit:
    """A pint unit from FMI notation: `.` multiplies, a trailing digit is an exponent, `1` is dimensionless.

    Raises
    ------
    ValueError
        If the unit is not known.
    """
    text = re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", unit.strip().replace(".", "*"))
    try:
        return registry().Unit("" if text == "1" else text)
    except (pint.UndefinedUnitError, pint.DefinitionSyntaxError, ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"unknown unit {unit!r}; use SI units such as m, mm, kg.m, N, N.s/m, rad/s, Hz") from error


def base_unit(unit: str) -> dict[str, float | int]:
    """Exponents of the FMI base units (kg, m, s, A, K, mol, cd, rad), and `factor` where it is not one."""
    parsed = parse_unit(unit)
    radians = int(dict(parsed._units).get("radian", 0))
    quantity = (1 * parsed).to_base_units()
    exponents: dict[str, float | int] = {
        _PINT_NAMES[name]: int(power) for name, power in dict(quantity.units._units).items() if name in _PINT_NAMES
    }
    if radians:
        exponents["rad"] = radians
    if not math.isclose(quantity.magnitude, 1.0, rel_tol=1e-12):
        exponents["factor"] = float(quantity.magnitude)
    return exponents


def to_unit(text: str | float, unit: str, name: str) -> float:
    """Number that `text` (`0.75 mm`, `25 g.m`, or a bare number already in `unit`) is in `unit`.

    Raises
    ------
    ValueError
        If `text` is no number, has an unknown unit, or one of another dimension.
    """
    if isinstance(text, int | float):
        return float(text)
    match = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf|nan)\s*(.*?)\s*", text)
    if match is None:
        raise ValueError(f"{name} = {text!r} is no number; write for example {name}=0.5 or {name}='0.5 {unit}'")
    number, given = float(match[1]), match[2]
    if not given:
        return number
    source, target = parse_unit(given), parse_unit(unit)
    try:
        return float((number * source).to(target).magnitude)
    except pint.DimensionalityError as error:
        raise ValueError(f"{name} = {text!r} has unit {given}, which cannot be converted to {unit}") from error
