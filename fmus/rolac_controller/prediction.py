"""Displacements and angle ahead of a step, for a master that passes them on late.

In Jacobi order with the step h the displacements of t reach the rotor as a force at t + 2 h. The controller then counts
with what will be there at t + p, p = `prediction_time` = 2 h, from the displacements at its last two steps, t_b and t:

    x(t + p) ~ x(t) + p (x(t) - x(t_b))/(t - t_b),      theta(t + p) ~ theta(t) + p Omega(t)

The first is off by x'' p (p + t - t_b)/2 to leading order. Sensors, with their noise, filter and faults, come after it.
"""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel
from fmi_export.model import Array
from rolac_controller.records import Inputs


@inlined_kernel
def predict(inputs: Inputs, prediction_time: float, time: float, head: np.record, last_displacements: Array) -> None:
    """Move angle and displacements of the inputs ahead, and remember the displacements as they were.

    Parameters
    ----------
    inputs
        Of the step from `time` (s) on; changed.
    prediction_time
        How far to look ahead, p (s).
    head
        The state's record HEAD: time of the step before, if there was one.
    last_displacements
        At the step before, shape (n_sensors,) (m).
    """
    own, elapsed = inputs.own[0], time - head.last_time
    own.theta += prediction_time * own.Omega
    share = prediction_time / elapsed if head.n_samples > 0.0 and elapsed > 0.0 else 0.0
    for k in range(last_displacements.shape[0]):
        x = inputs.displacements[k]
        inputs.displacements[k] = x + share * (x - last_displacements[k])
        last_displacements[k] = x
    head.last_time = time
