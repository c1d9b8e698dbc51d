"""Analogue-to-digital and digital-to-analogue converters: resolution and range."""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel


class Converter(NamedTuple):
    """Least significant bit (V) of a converter, and its number of levels below zero, which is one more than above."""

    step: float
    half: float


@kernel
def converter_of(bits: float, reach: float) -> Converter:
    """Return the converter of 2^bits levels from -reach to reach - 1 bit (V)."""
    return Converter(2.0 * reach / 2.0**bits, 2.0 ** (bits - 1.0))


@kernel
def quantised(volts: float, converter: Converter) -> float:
    """Return the nearest level of a converter (V)."""
    step, half = converter
    level = min(max(volts / step, -half), half - 1.0)
    return math.floor(level + 0.5) * step
