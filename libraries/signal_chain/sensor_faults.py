"""Faults of a sensor: dead, stuck, offset."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel


@kernel
def with_faults(faults: np.record, healthy: float, last: float) -> float:
    """Return the signal of a sensor under its faults; noise has already been added.

    Dead: 0, regardless of the other faults. Stuck: its last signal. Offset: added to the signal without faults.

    Parameters
    ----------
    faults
        The sensor's fault inputs.
    healthy, last
        Signal without faults, and signal at the previous sample (m).
    """
    if faults.dead:
        return 0.0
    if faults.stuck:
        return last
    signal: float = healthy + faults.offset
    return signal
