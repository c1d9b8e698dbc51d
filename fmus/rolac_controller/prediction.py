"""Prediction of displacements and rotor angle, for co-simulation masters that delay connections.

If a master steps FMUs in Jacobi order with the step h, displacements at t affect the force on the rotor at t + 2 h. The
controller therefore extrapolates to t + p, where p = `prediction_time` = 2 h, from the displacements at the times t_b
and t of its last two steps:

    x(t + p) ~ x(t) + p (x(t) - x(t_b))/(t - t_b),      theta(t + p) ~ theta(t) + p Omega(t)

The extrapolated x has an error of x'' p (p + t - t_b)/2 to leading order. Noise, filters and faults of sensors are
applied afterwards.
"""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel
from fmi_export.model import Array
from rolac_controller.records import Inputs


@inlined_kernel
def predict(inputs: Inputs, prediction_time: float, time: float, head: np.record, last_displacements: Array) -> None:
    """Extrapolate the angle and the displacements in the inputs, and store the original displacements.

    Parameters
    ----------
    inputs
        Inputs of the step that begins at `time` (s); changed.
    prediction_time
        Extrapolation time p (s).
    head
        Record HEAD of the state, which contains the time of the previous step, if any.
    last_displacements
        Displacements at the previous step, shape (n_sensors,) (m); receives those of this step.
    """
    common, elapsed = inputs.common[0], time - head.last_time
    common.theta += prediction_time * common.Omega
    share = prediction_time / elapsed if head.n_samples > 0.0 and elapsed > 0.0 else 0.0
    for k in range(last_displacements.shape[0]):
        x = inputs.displacements[k]
        inputs.displacements[k] = x + share * (x - last_displacements[k])
        last_displacements[k] = x
    head.last_time = time
