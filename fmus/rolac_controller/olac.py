"""Open-loop adaptive control, the predecessor of ROLAC: an update from a full revolution of steady vibration.

    U <- U + H(Omega) Q     where |Q - Q one revolution before| <= steadiness |Q|

After an update the next comparison needs two revolutions of new data, and so waits until the rotor has settled.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.fourier import N_Q, SLACK
from rolac_controller.interface import STEADINESS, UPDATES
from rolac_controller.names import N_HARMONICS

TURNED, REVOLUTIONS, DONE = range(3)
BEFORE = 3
N_MEMORY = BEFORE + N_HARMONICS * N_Q


@kernel
def due(parameters: Array, turn: float, q: Array, memory: Array) -> bool:
    """Whether this sample ends a revolution of steady vibration, and an update is allowed.

    Parameters
    ----------
    turn
        Angle since the sample before (rad).
    q
        Components of all harmonics, shape (N_HARMONICS N_Q,) (m).
    memory
        Shape (N_MEMORY,); all zeros when OLAC is switched on.
    """
    if parameters[UPDATES] > 0.0 and memory[DONE] >= parameters[UPDATES]:
        return False
    memory[TURNED] += turn
    if memory[TURNED] < 2.0 * math.pi - SLACK:
        return False
    memory[TURNED] -= 2.0 * math.pi
    memory[REVOLUTIONS] += 1.0
    change = size = 0.0
    for i in range(N_HARMONICS * N_Q):
        change += (q[i] - memory[BEFORE + i]) ** 2
        size += q[i] * q[i]
        memory[BEFORE + i] = q[i]
    steady = memory[REVOLUTIONS] >= 2.0 and change <= parameters[STEADINESS] ** 2 * size
    if steady:
        memory[REVOLUTIONS] = 0.0
        memory[DONE] += 1.0
    return bool(steady)
