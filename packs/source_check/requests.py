"""Requests for a quantity of a run or of a study, and their evaluation."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from amb_cosim.cosim.system.values import quantity
from amb_cosim.presentation.json_data import json_data
from source_check.verdict import Computed


@dataclass(frozen=True)
class QuantityRequest:
    """A quantity with its arguments and the requested unit."""

    quantity: str
    arguments: tuple[tuple[str, Any], ...]
    unit: str

    @property
    def key(self) -> str:
        """Text that identifies the request."""
        return json.dumps([self.quantity, dict(self.arguments), self.unit], sort_keys=True)


def evaluate(subject: Any, request: QuantityRequest, quantities: Mapping[str, Any]) -> Computed | None:
    """Return a quantity of a run or of a study in the requested unit, or None if it has no value.

    Raises
    ------
    ValueError
        If there is no such quantity, or the unit has another dimension.
    """
    if request.quantity not in quantities:
        raise ValueError(f"there is no quantity {request.quantity!r}; it must be one of {', '.join(quantities)}")
    function, unit = quantities[request.quantity]
    value = json_data(function(subject, **dict(request.arguments)))
    if value is None or isinstance(value, bool | str):
        return value
    factor = (
        quantity(f"1 {request.unit}", unit, request.quantity) if unit and request.unit and unit != request.unit else 1.0
    )
    numbers = [number / factor for number in (value if isinstance(value, list) else [value])]
    if not all(math.isfinite(number) for number in numbers):
        return None
    return numbers if isinstance(value, list) else numbers[0]
