"""Number types with limits and units for rotor files."""

from __future__ import annotations

import math
import re
from typing import Annotated

from annotated_types import Ge, Gt
from pydantic import AfterValidator, BeforeValidator, StrictFloat, StrictInt, StrictStr

from amb_files.validation_errors import Unit

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
SPEED_UNITS = {"rpm": 2.0 * math.pi / 60.0, "1/min": 2.0 * math.pi / 60.0, "Hz": 2.0 * math.pi, "rad/s": 1.0}


def as_tuple(value: object) -> object:
    """Return a single value as a tuple of length 1, and a list unchanged."""
    return value if isinstance(value, list | tuple) else (value,)


def _identifier(name: str) -> str:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError("it must consist of letters, digits and underscores, and not begin with a digit")
    return name


def _variable(name: str) -> str:
    if not all(IDENTIFIER.fullmatch(part) for part in name.split(".")):
        raise ValueError("it must be the name of a variable, such as tip or motor_end.x")
    return name


def _moderate(value: float) -> float:
    """Refuse values that would overflow in products and powers within the model."""
    if value != 0.0 and not 1e-20 <= abs(value) <= 1e20:
        raise ValueError("it must be from 1e-20 to 1e20 in magnitude")
    return value


Moderate = AfterValidator(_moderate)
Node = Annotated[StrictInt, Ge(1)]
Position = Annotated[StrictFloat, Moderate, Unit("m")]
Offset = Annotated[StrictFloat, Moderate, Unit("m")]
Length = Annotated[StrictFloat, Gt(0.0), Moderate, Unit("m")]
Size = Annotated[StrictFloat, Ge(0.0), Moderate, Unit("m")]
Mass = Annotated[StrictFloat, Ge(0.0), Moderate, Unit("kg")]
Inertia = Annotated[StrictFloat, Ge(0.0), Moderate, Unit("kg m2")]
Name = Annotated[StrictStr, AfterValidator(_identifier)]
Variable = Annotated[StrictStr, AfterValidator(_variable)]


def speed_in_si(value: object) -> object:
    """Return a speed in rad/s if it is given as a text with a unit; return anything else unchanged.

    Examples
    --------
    >>> round(speed_in_si("9900 rpm"), 1)
    1036.7
    """
    if not isinstance(value, str):
        return value
    number, _, unit = value.strip().partition(" ")
    try:
        return float(number) * SPEED_UNITS[unit.strip()]
    except (ValueError, KeyError):
        raise ValueError(f"it must be a number with its unit, {', '.join(SPEED_UNITS)}, such as '9900 rpm'") from None


Speed = Annotated[StrictFloat, BeforeValidator(speed_in_si), Moderate, Unit("rad/s")]
SPEED_KEYS = "speed", "whirl_frequency"  # of a rotor file
