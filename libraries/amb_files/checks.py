"""Checks of values, with messages that state what is allowed."""

from __future__ import annotations

import math


def require(condition: bool, what: str, value: object, allowed: str) -> None:
    """Raise a ValueError with the name `what`, its value and what is allowed, unless `condition` holds."""
    if not condition:
        raise ValueError(f"{what} = {value} is not allowed; it must be {allowed}")


def require_positive(record: object, **units: str) -> None:
    """Raise a ValueError unless the fields that `units` names, with a unit each or "", are finite and above zero."""
    for name, unit in units.items():
        value = getattr(record, name)
        require(0.0 < value < math.inf, name, f"{value:g} {unit}".rstrip(), f"> 0 {unit}".rstrip())
