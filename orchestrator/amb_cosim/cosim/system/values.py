"""Values as users write them (`0.75 mm`), converted to the units of an FMU and checked against its limits."""

from __future__ import annotations

import math
import re

from amb_cosim.cosim.fmu.fmu_interface import Port
from fmi_export.building.units import to_unit

Raw = bool | int | float | str
RPM = 30.0 / math.pi  # 1/min of a rad/s

_BOOLEANS = {"true": 1.0, "false": 0.0, "1": 1.0, "0": 0.0}


def quantity(raw: Raw, unit: str, name: str) -> float:
    """Convert `raw` (`0.75 mm`, `16 Hz`, or a number already in `unit`) to a number in `unit`.

    Raises
    ------
    ValueError
        If `raw` is not a number, or has an unknown unit or one of another dimension.
    """
    if isinstance(raw, bool):
        raise ValueError(f"{name} = {str(raw).lower()} is no number")
    return to_unit(raw, unit, name)


def convert(raw: Raw, port: Port, name: str) -> float:
    """Convert `raw` to a number in the unit of `port`; booleans are 0 and 1, names of an Enumeration their values.

    Raises
    ------
    ValueError
        If the port does not accept it; the message names the value and the allowed ones.
    """
    if port.type == "Boolean":
        text = str(raw).strip().lower()
        if text not in _BOOLEANS:
            raise ValueError(f"{name} = {raw} is not allowed; it must be true or false")
        return _BOOLEANS[text]
    if port.items and isinstance(raw, str) and not _is_number(raw):
        if raw.strip() not in port.items:
            raise ValueError(f"{name} = {raw} is not allowed; it must be {port.allowed()}")
        return float(port.items[raw.strip()])
    value = quantity(raw, port.unit or "1", name)
    within = value in port.items.values() if port.items else port.minimum <= value <= port.maximum
    if port.type == "Integer" and not port.items and value != math.floor(value if math.isfinite(value) else 0.5):
        raise ValueError(f"{name} = {raw} is not allowed; it must be a whole number {_bounds(port)}".rstrip())
    if not (within and math.isfinite(value)):
        values = f" ({raw})" if isinstance(raw, str) and not _is_number(raw) else ""
        raise ValueError(f"{name} = {value:.9g}{port.display_unit}{values} is not allowed; it must be {port.allowed()}")
    return value


def is_zero(raw: Raw) -> bool:
    """Return whether a value is `false` or 0, in any unit."""
    if isinstance(raw, str):
        text = raw.strip().lower()
        return text == "false" or re.fullmatch(r"[+-]?(0+\.?0*|\.0+)(e[+-]?\d+)?(\s*[^\W\d].*)?", text) is not None
    return raw == 0


def _bounds(port: Port) -> str:
    allowed = port.allowed()
    return "" if allowed == "a finite number" else allowed


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
