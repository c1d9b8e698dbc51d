"""Open-loop adaptive control, the predecessor of ROLAC: an update from a full revolution of steady vibration.

    U <- U + H(Omega) Q     where |Q - Q one revolution before| <= steadiness |Q|

After an update the next comparison needs two revolutions of new data, and so waits until the rotor has settled.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record
from rolac_controller.complex_numbers import Complex, squared_magnitude
from rolac_controller.fourier import ANGLE_TOLERANCE
from rolac_controller.rig_layout import N_HARMONICS, N_SENSORS

OLAC_MEMORY = record(
    ("angle", "f8"),  # since the last whole revolution (rad)
    ("n_revolutions", "f8"),  # since the last update
    ("n_updates", "f8"),
    ("previous_Q", "c16", (N_HARMONICS, N_SENSORS)),  # one revolution before (m)
)


@kernel
def update_is_due(olac: np.record, delta_theta: float, Q: Complex, memory: np.record) -> bool:
    """Return whether this sample ends a revolution of steady vibration, and an update is allowed.

    Parameters
    ----------
    olac
        The parameters `olac.*`.
    delta_theta
        Angle since the sample before (rad).
    Q
        Components of all harmonics, shape (N_HARMONICS, N_SENSORS) (m).
    memory
        Record OLAC_MEMORY; all zeros when OLAC is switched on.
    """
    if olac.updates > 0.0 and memory.n_updates >= olac.updates:
        return False
    angle = memory.angle + delta_theta
    memory.angle = angle
    if angle < 2.0 * math.pi - ANGLE_TOLERANCE:
        return False
    memory.angle = angle - 2.0 * math.pi
    n_revolutions = memory.n_revolutions + 1.0
    change_squared = size_squared = 0.0
    for k in range(N_HARMONICS):
        for s in range(N_SENSORS):
            change = Q[k, s] - memory.previous_Q[k, s]
            change_squared += squared_magnitude(change)
            size_squared += squared_magnitude(Q[k, s])
            memory.previous_Q[k, s] = Q[k, s]
    steady = n_revolutions >= 2.0 and change_squared <= olac.steadiness**2 * size_squared
    memory.n_revolutions = 0.0 if steady else n_revolutions
    if steady:
        memory.n_updates += 1.0
    return bool(steady)
