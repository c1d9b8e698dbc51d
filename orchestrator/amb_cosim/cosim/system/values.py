"""Values as users write them (`0.75 mm`), converted to the units of an FMU and checked against its limits."""

from __future__ import annotations

import math
import re

from amb_cosim.cosim.fmu.fmu_interface import Port, UnitDefinition
from amb_files.plain_values import Plain as Plain
from amb_files.plain_values import Raw as Raw
from amb_files.plain_values import plain_value as plain_value
from amb_files.speed_units import require_speed_unit
from fmi_export.building.number_texts import plain_forms
from fmi_export.building.units import COMMON, SI, parse_unit, to_unit

RPM = 30.0 / math.pi  # 1/min per rad/s

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*\S)\s*")
TURNING = ("rad/s", "Hz")  # units of speeds and frequencies, for which a text without a unit may mean rpm


def quantity(raw: Raw, unit: str, name: str) -> float:
    """Convert `raw` (`0.75 mm`, `16 Hz`, or a number already in `unit`) to a number in `unit`.

    Raises
    ------
    ValueError
        If `raw` is not a finite number, has an unknown unit or a unit of another dimension, or is a speed or frequency
        as a text without a unit.
    """
    raw = plain_value(raw, name)
    if unit in TURNING:
        require_speed_unit(raw, name)
    value = _number(raw, unit, name)
    if not math.isfinite(value):
        raise ValueError(f"{name} = {raw} is not allowed; it must be finite")
    return value


def _number(raw: Plain, unit: str, name: str) -> float:
    """Convert `raw` as `quantity` does; infinities and NaN are left to the caller."""
    if isinstance(raw, bool):
        raise ValueError(f"{name} = {str(raw).lower()} is not a number")
    return to_unit(raw, unit, name)


def plain_number(raw: Raw) -> float | None:
    """Return a number without a unit, which may be given as text; None for a Boolean or any other text."""
    raw = plain_value(raw, "value")
    if isinstance(raw, bool):
        return None
    try:
        return float(raw)
    except ValueError:
        return None


def stated(value: str, raw: Raw) -> str:
    """Return a converted value for a message, followed by the user's text if this text contains a unit."""
    raw = plain_value(raw, "value")
    is_other = isinstance(raw, str) and plain_number(raw) is None and raw.split() != value.split()
    return f"{value} ({raw})" if is_other else value


def convert(raw: Raw, port: Port, name: str) -> float:
    """Convert `raw` to a number in the unit of `port`; Booleans become 0 or 1, and Enumeration names their values.

    Raises
    ------
    ValueError
        If the port does not accept it; the message names the value and the allowed values.
    """
    raw = plain_value(raw, name)
    if port.type == "Boolean":
        number = {"true": 1.0, "false": 0.0}.get(str(raw).strip().lower(), plain_number(raw))
        if number not in (0.0, 1.0):
            raise ValueError(f"{name} = {raw} is not allowed; it must be true or false")
        return number
    if port.items and isinstance(raw, str) and plain_number(raw) is None:
        if raw.strip() not in port.items:
            raise ValueError(f"{name} = {raw} is not allowed; it must be {port.allowed()}")
        return float(port.items[raw.strip()])
    if port.unit in TURNING:
        require_speed_unit(raw, name)
    value = _in_unit_of(port, raw, name)
    is_allowed = value in port.items.values() if port.items else port.minimum <= value <= port.maximum
    if port.type == "Integer" and not port.items and value != math.floor(value if math.isfinite(value) else 0.5):
        raise ValueError(f"{name} = {raw} is not allowed; it must be a whole number {_bounds(port)}".rstrip())
    if not (is_allowed and math.isfinite(value)):
        shown = stated(f"{value:.9g}{port.display_unit}", raw)
        raise ValueError(f"{name} = {shown} is not allowed; it must be {port.allowed()}")
    return value


def _in_unit_of(port: Port, raw: Plain, name: str) -> float:
    """Convert `raw` to a number in the unit of a variable; units that the FMU defines have the meaning defined there.

    With the FMU's definitions of both units, b = F v + O in the same base units, the number is (F v + O - O') / F'.
    """
    value = _in_absolute_unit_of(port, raw, name)
    match = _QUANTITY.fullmatch(raw) if port.relative and isinstance(raw, str) else None
    return value if match is None else value - _in_absolute_unit_of(port, f"0 {match[2]}", name)


def _in_absolute_unit_of(port: Port, raw: Plain, name: str) -> float:
    """Convert `raw` as an absolute quantity, with the offsets of units."""
    port_unit, match = port.unit or "1", _QUANTITY.fullmatch(raw) if isinstance(raw, str) else None
    if match is None or match[2] == port_unit or (match[2], port_unit) in COMMON or plain_forms(match[0]):
        return _number(raw, port_unit, name)  # which refuses a number with separators
    number, unit = float(match[1]), match[2]
    scale, declared = port.units.get(unit), port.definition
    if scale is not None and declared is not None and scale[:-2] == declared[:-2] and declared[-2]:
        return (scale[-2] * number + scale[-1] - declared[-1]) / declared[-2]
    if _is_standard(port):
        return _number(raw, port_unit, name)
    if len(port_unit) > 2 and unit == f"{port_unit}s":
        return number
    try:
        if declared is None or not declared[-2]:
            raise ValueError(f"{port_unit} has no definition")
        return (_number(raw, _base(declared), name) - declared[-1]) / declared[-2]
    except ValueError as error:
        units = ", ".join(dict.fromkeys([port_unit, *port.units]))
        raise ValueError(
            f"{name} = {raw!r} is not allowed; it must be a number in {port_unit}; the FMU declares the units {units}"
        ) from error


def _is_standard(port: Port) -> bool:
    """Return whether the unit of a variable has its usual meaning, which it also has if the FMU does not define it."""
    try:
        if port.definition is None:
            parse_unit(port.unit or "1")
            return True
        zero, one = (to_unit(f"{value} {port.unit}", _base(port.definition), "unit") for value in (0, 1))
    except ValueError:
        return False
    factor, offset = port.definition[-2:]
    pairs = (zero, offset), (one, factor + offset)
    return all(math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-9 * abs(factor)) for a, b in pairs)


def _base(definition: UnitDefinition) -> str:
    """Return the product of base units in a definition."""
    return ".".join(f"{unit}{power:g}" for unit, power in zip(SI, definition, strict=False) if power) or "1"


def is_zero(raw: Raw) -> bool:
    """Return whether a value is `false` or 0, in any unit."""
    raw = plain_value(raw, "value")
    if isinstance(raw, str):
        text = raw.strip().lower()
        return text == "false" or re.fullmatch(r"[+-]?(0+\.?0*|\.0+)(e[+-]?\d+)?(\s*[^\W\d].*)?", text) is not None
    return raw == 0


def _bounds(port: Port) -> str:
    allowed = port.allowed()
    return "" if allowed == "a finite number" else allowed
