"""Open-loop adaptive control, the predecessor of ROLAC: it updates the forces after a revolution of steady vibration.

    U <- U + H(Omega) Q     where |Q - Q a revolution before| <= steadiness |Q|

After an update, the next comparison requires two revolutions of new data, so the rotor has time to settle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import clear, part
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import COMPLEX, Complex, squared_magnitude
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.fourier import ANGLE_TOLERANCE
from rolac_controller.sizes import Records

PROGRESS = record(
    ("angle", "f8"),  # since the last whole revolution (rad)
    ("n_revolutions", "f8"),  # since the last update
    ("n_updates", "f8"),
)
N_PROGRESS = size_of(PROGRESS)


class OlacMemory(NamedTuple):
    """Record PROGRESS (length 1), and Q of the previous revolution, shape (N_HARMONICS, n_sensors) (m)."""

    progress: Records
    previous_Q: Complex


@views
def olac_memory_size(n_sensors: int) -> int:
    """Return the size of the memory for this number of sensors."""
    return N_PROGRESS + 2 * N_HARMONICS * n_sensors


@views
def olac_memory_of(array: Array, start: int, n_sensors: int) -> OlacMemory:
    """Return the memory as views into an array, beginning at `start`."""
    previous_Q = part(array, start + N_PROGRESS, COMPLEX, (N_HARMONICS, n_sensors))
    return OlacMemory(part(array, start, PROGRESS, 1), previous_Q)


@inlined_kernel
def forget(memory: OlacMemory) -> None:
    """Clear the memory if it is not already clear."""
    progress = memory.progress[0]
    if progress.angle != 0.0 or progress.n_revolutions != 0.0 or progress.n_updates != 0.0:
        progress.angle = 0.0
        progress.n_revolutions = 0.0
        progress.n_updates = 0.0
        clear(memory.previous_Q)


@kernel
def update_is_due(olac: np.record, delta_theta: float, Q: Complex, memory: OlacMemory) -> bool:
    """Return whether this sample completes a revolution of steady vibration and another update is allowed.

    Parameters
    ----------
    olac
        The parameters `olac.*`.
    delta_theta
        Rotor angle since the previous sample (rad).
    Q
        Components of all harmonics, shape (N_HARMONICS, n_sensors) (m).
    memory
        Progress and previous Q, updated; all zeros when OLAC is switched on.
    """
    progress = memory.progress[0]
    if olac.updates > 0.0 and progress.n_updates >= olac.updates:
        return False
    angle = progress.angle + delta_theta
    progress.angle = angle
    if angle < 2.0 * math.pi - ANGLE_TOLERANCE:
        return False
    progress.angle = angle - 2.0 * math.pi
    n_revolutions = progress.n_revolutions + 1.0
    change_squared = size_squared = 0.0
    for k in range(N_HARMONICS):
        for s in range(Q.shape[1]):
            change = Q[k, s] - memory.previous_Q[k, s]
            change_squared += squared_magnitude(change)
            size_squared += squared_magnitude(Q[k, s])
            memory.previous_Q[k, s] = Q[k, s]
    steady = n_revolutions >= 2.0 and change_squared <= olac.steadiness**2 * size_squared
    progress.n_revolutions = 0.0 if steady else n_revolutions
    if steady:
        progress.n_updates += 1.0
    return bool(steady)
