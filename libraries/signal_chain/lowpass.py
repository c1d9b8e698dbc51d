"""Anti-aliasing filter of a sensor: a sampled first-order low-pass.

    F(s) = omega / (s + omega)
    y_(n+1) = E y_n + (1 - E - P) x_n + P x_(n+1),    E = exp(-omega h),    P = 1 - (1 - E)/(omega h)

Each step is exact for a signal that is linear between samples. Frequencies above half the sampling frequency never
reach the FMU, so the filter's lag and attenuation are modelled, but not the aliasing that it prevents.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record

FILTER = record(("output", "f8"), ("input", "f8"))  # at the sample before


@kernel
def coefficients(cutoff: float, sample_time: float) -> tuple[float, float]:
    """Return E and P for a cut-off frequency (Hz) and a sample time (s)."""
    omega_h = 2.0 * math.pi * cutoff * sample_time
    E = math.exp(-omega_h)
    return E, 1.0 - (1.0 - E) / omega_h


@kernel
def start_at_rest(memory: np.record, x: float) -> None:
    """Set the memory of a filter, record FILTER, to the steady state for a constant input `x`."""
    memory.output = x
    memory.input = x


@kernel
def filter_sample(memory: np.record, x: float, E: float, P: float) -> float:
    """Return the filter's output for the next sample `x` of its input."""
    y: float = E * memory.output + (1.0 - E - P) * memory.input + P * x
    memory.output = y
    memory.input = x
    return y
