"""Damping zones, each defined by the logarithmic decrement at its upper end; functions that show damping as text."""

from __future__ import annotations

import math

from rotor_analysis.modes import Whirl
from rotor_analysis.spectrum import AT_REST

ROUNDING = 1e-7  # damping ratio
AMPLIFYING = 2.0 * math.pi * 0.2 / math.sqrt(1.0 - 0.2**2)  # zeta = 0.2: an amplification 1/(2 zeta) of 2.5

REQUIRED = 0.1  # decrement (API 617)

# Upper limit and name of each zone (API 617: level II stability; a mode with an amplification below 2.5 is not a
# critical speed).
ZONES = (
    (0.0, "unstable"),
    (REQUIRED, "less than API 617 requires"),
    (AMPLIFYING, "amplifies more than 2.5 times"),
)


def damping_ratio(decrement: float) -> float:
    """Return the damping ratio of a logarithmic decrement: zeta = delta / sqrt(4 pi^2 + delta^2)."""
    return decrement / math.hypot(2.0 * math.pi, decrement)


def damping_cells(ratio: float, frequency: float, whirl: Whirl) -> tuple[str, str]:
    """Return the damping ratio and the whirl of a mode (frequency in rad/s) as text, with a mark if the mode grows.

    A mode grows if its damping ratio is below zero by more than the rounding error. This error depends on the
    frequency, because rounding can change the square of an eigenvalue by the square of `AT_REST`.
    """
    grows = ratio < -max(ROUNDING, (AT_REST / frequency) ** 2)
    text = f"{ratio if grows else max(ratio, 0.0):z.4f}"
    return text, whirl + (", unstable" if grows else "")
