"""Number types with limits and units for rotor files."""

from __future__ import annotations

import re
from typing import Annotated

from annotated_types import Ge, Gt
from pydantic import AfterValidator, StrictFloat, StrictInt, StrictStr

from amb_files.validation_errors import Unit

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def as_tuple(value: object) -> object:
    """Return a single value as a tuple of length 1, and a list unchanged."""
    return value if isinstance(value, list | tuple) else (value,)


def _identifier(name: str) -> str:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError("it must be letters, digits and underscores, not beginning with a digit")
    return name


def _variable(name: str) -> str:
    if not all(IDENTIFIER.fullmatch(part) for part in name.split(".")):
        raise ValueError("it must be the name of a variable, such as tip or motor_end.x")
    return name


def _moderate(value: float) -> float:
    """Refuse values that overflow in the model's products and powers."""
    if value != 0.0 and not 1e-20 <= abs(value) <= 1e20:
        raise ValueError("it must be from 1e-20 to 1e20 in size")
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
