"""Checks that nonzero speeds and frequencies in files have units; a bare number could mean rpm, Hz or rad/s.

In Python, a number without a unit is in rad/s.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any


def require_speed_units(data: object, keys: Collection[str], place: str = "") -> None:
    """Raise a ValueError if a value of one of `keys`, at any depth of a file's data, is a number without a unit.

    Examples
    --------
    >>> require_speed_units({"seals": [{"speed": 0.0}, {"speed": 12000}]}, {"speed"})
    Traceback (most recent call last):
        ...
    ValueError: seals[1].speed = 12000 has no unit; write for example '12000 rpm', '12000 Hz' or '12000 rad/s'
    """
    if isinstance(data, dict):
        for key, value in data.items():
            inner = f"{place}.{key}" if place else str(key)
            if key in keys:
                require_speed_unit(str(value) if _is_number(value) else value, inner)
            require_speed_units(value, keys, inner)
    elif isinstance(data, list):
        for k, item in enumerate(data):
            require_speed_units(item, keys, f"{place}[{k}]")


def require_speed_unit(written: object, name: str = "Omega") -> None:
    """Raise a ValueError if a text is a speed without a unit and is not 0."""
    if isinstance(written, str):
        try:
            is_zero = float(written) == 0.0
        except ValueError:
            return
        value = written.strip()
        if not is_zero:
            raise ValueError(
                f"{name} = {value} has no unit; write for example '{value} rpm', '{value} Hz' or '{value} rad/s'"
            )


def with_speed_units(data: Any, keys: Collection[str]) -> Any:
    """Return the data of a file, with the unit rad/s added to numbers whose keys, at any depth, are in `keys`."""
    if isinstance(data, dict):
        return {
            key: f"{float(value)!r} rad/s" if key in keys and _is_number(value) else with_speed_units(value, keys)
            for key, value in data.items()
        }
    return [with_speed_units(item, keys) for item in data] if isinstance(data, list) else data


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
