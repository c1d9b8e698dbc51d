"""Analogue-to-digital and digital-to-analogue converters: resolution and range."""

from __future__ import annotations

import math

from fmi_export.jit import kernel


@kernel
def resolution(bits: float, reach: float) -> float:
    """Return the least significant bit (V) of a converter of -reach to reach volts."""
    return 2.0 * reach / 2.0**bits


@kernel
def quantised(volts: float, bits: float, reach: float) -> float:
    """Return the nearest of the 2^bits levels -reach, .., reach - 1 bit (V)."""
    step = resolution(bits, reach)
    half = 2.0 ** (bits - 1.0)
    level = min(max(volts / step, -half), half - 1.0)
    return math.floor(level + 0.5) * step
