"""Zones of damping, by the logarithmic decrements at which they end."""

from __future__ import annotations

import math

AMPLIFYING = 2.0 * math.pi * 0.2 / math.sqrt(1.0 - 0.2**2)  # zeta = 0.2: an amplification 1/(2 zeta) of 2.5

# Upper limits, and what the zone below is (API 617: stability of level II; a mode with an amplification below 2.5 is no
# critical speed).
ZONES = (
    (0.0, "unstable"),
    (0.1, "less than API 617 requires"),
    (AMPLIFYING, "amplifies more than 2.5 times"),
)


def damping_ratio(decrement: float) -> float:
    """Return the damping ratio of a logarithmic decrement: zeta = delta / sqrt(4 pi^2 + delta^2)."""
    return decrement / math.hypot(2.0 * math.pi, decrement)
