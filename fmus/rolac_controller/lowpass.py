"""Anti-aliasing filter of one sensor: a first-order low-pass, as its samples see it.

    F(s) = omega / (s + omega)
    y_(n+1) = E y_n + (1 - E - P) x_n + P x_(n+1),    E = exp(-omega h),    P = 1 - (1 - E)/(omega h)

Between samples the signal counts as linear, and then each step is exact. What lies above half the sampling frequency
has never been seen by the FMU: the filter's lag and attenuation are modelled, not the aliasing that it prevents.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array

N_FILTER = 2
OUTPUT, INPUT = range(N_FILTER)  # at the sample before


@kernel
def coefficients(cutoff: float, sample_time: float) -> tuple[float, float]:
    """E and P for a cut-off frequency (Hz) and a sample time (s)."""
    turn = 2.0 * math.pi * cutoff * sample_time
    decay = math.exp(-turn)
    return decay, 1.0 - (1.0 - decay) / turn


@kernel
def settle(memory: Array, x: float) -> None:
    """Memory of a filter, shape (N_FILTER,), at rest at `x`."""
    memory[OUTPUT] = memory[INPUT] = x


@kernel
def filtered(memory: Array, x: float, decay: float, new: float) -> float:
    """Output of the filter for the next sample `x` of its input; `decay` and `new` are E and P."""
    y: float = decay * memory[OUTPUT] + (1.0 - decay - new) * memory[INPUT] + new * x
    memory[OUTPUT], memory[INPUT] = y, x
    return y
