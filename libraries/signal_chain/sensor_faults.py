"""Faults of a sensor: dead, stuck, offset."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel


@kernel
def with_faults(faults: np.record, healthy: float, last: float) -> float:
    """Return the signal of a sensor with its faults, except noise, which has already been added.

    A dead sensor gives 0, regardless of its other faults; a stuck sensor repeats its last signal. An offset is added to
    the signal without faults.

    Parameters
    ----------
    faults
        The sensor's fault inputs.
    healthy, last
        The signal without faults, and the signal at the previous sample (m).
    """
    if faults.dead:
        return 0.0
    if faults.stuck:
        return last
    signal: float = healthy + faults.offset
    return signal
