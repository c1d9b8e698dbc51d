"""Sampling instants of the controller, which are independent of the communication step.

The instants are t_n = begin + n T with T = `sample_time`; `begin` is the time of the first step. A step [t, t + h) that
contains an instant takes the sample with its inputs, and the currents are held until the next one:

    t_n           |               |               |               |
    h = T/4       *   .   .   .   *   .   .   .   *   .   .   .   *        * sample, . nothing changes
    h = 0.7 T     *          .          *          *          *            up to h before its instant

An instant at the end of a step belongs to the next one. Masters round: n h differs from t_n in its last digits, and a
sum of steps drifts by up to n^2 1e-16 h, 2e-5 h after a million steps. The last `TOLERANCE` h of a step therefore count
as its end: the sample of an instant there is late by at most `TOLERANCE` h, while others are early by up to h. If a sum
has drifted further, samples are taken a step earlier. With h = T no sample is lost, because a step takes at most one.

A step longer than T would contain two instants, but have inputs for only the first.
"""

from __future__ import annotations

from fmi_export.jit import inlined_kernel

TOLERANCE = 1e-3  # of the communication step
LONGEST_STEP = 1.0 + 1e-9  # samples, for masters that round sample_time differently
ROUNDING = 4.5e-16  # relative to the time, from which a master computes the step by subtraction


@inlined_kernel
def is_due(instant: float, time: float, step_size: float) -> bool:
    """Return whether the step of `step_size` from `time` takes the sample of this instant (all in s)."""
    return instant < time + (1.0 - TOLERANCE) * step_size


@inlined_kernel
def is_too_long(time: float, step_size: float, sample_time: float) -> bool:
    """Return whether the step of `step_size` from `time` is longer than the sample time beyond rounding (all in s)."""
    return step_size > LONGEST_STEP * sample_time + ROUNDING * abs(time)
