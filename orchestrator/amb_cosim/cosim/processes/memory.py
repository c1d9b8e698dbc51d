"""The memory of this machine."""

from __future__ import annotations

import math
import os


def physical_memory() -> float:
    """Return the memory of this machine (B); infinite if the system does not state it."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf
