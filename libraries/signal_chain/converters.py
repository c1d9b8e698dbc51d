"""Analogue-to-digital and digital-to-analogue converters: resolution and range."""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel


class Converter(NamedTuple):
    """Least significant bit (V) of a converter, and its number of levels below zero (one more than above zero)."""

    step: float
    half: float


@kernel
def converter_of(bits: float, reach: float) -> Converter:
    """Return a converter with 2^bits levels from -reach (V) to one level below reach."""
    return Converter(2.0 * reach / 2.0**bits, 2.0 ** (bits - 1.0))


@kernel
def quantised(volts: float, converter: Converter) -> float:
    """Return the level of a converter that is nearest to a voltage (V)."""
    step, half = converter
    level = min(max(volts / step, -half), half - 1.0)
    return math.floor(level + 0.5) * step
