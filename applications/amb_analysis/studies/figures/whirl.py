"""Colour and line style of each whirl direction."""

from __future__ import annotations

from typing import Any

from amb_cosim.presentation.style import BLUE, DASHED, ORANGE, PURPLE

WHIRL_STYLES: dict[str, tuple[str, Any]] = {
    "backward": (ORANGE, DASHED),
    "forward": (BLUE, "-"),
    "mixed": (PURPLE, ":"),
}
