"""How a communication step is cut into pieces: at the controller's samples, which come at its own instants."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel, kernel
from rolac_controller.sampling import TOLERANCE, is_due, is_too_long
from rolac_controller.state import HEAD

SAME = 1e-9  # relative; a piece that differs less from the sample time, or by the rounding of the time, is one
ROUNDING = 1e-15  # relative; of the time, which a master subtracts to find the step

CLOCK = HEAD  # the controller's state begins with it


@inlined_kernel
def next_sample(clock: np.record, time: float, sample_time: float) -> float:
    """Return the instant of the next sample (s): `time` for the first."""
    return clock.begin + clock.n_samples * sample_time if clock.n_samples > 0.0 else time


@kernel
def piece(instant: float, time: float, step_size: float, sample_time: float) -> float:
    """Return the size of the first piece of the step of `step_size` from `time`, with the next sample at `instant` (s).

    A piece takes a sample at its beginning or none, and is no longer than the sample time.
    """
    if not is_due(instant, time, step_size):
        return step_size
    if instant > time + TOLERANCE * min(step_size, sample_time):
        return instant - time
    return sample_time if is_too_long(time, step_size, sample_time) else step_size


@inlined_kernel
def whole_sample(size: float, time: float, sample_time: float) -> float:
    """Return the sample time in place of a size that is the same but for rounding, else the size (s)."""
    same = abs(size - sample_time) <= SAME * sample_time + ROUNDING * abs(time)
    return sample_time if same else size
