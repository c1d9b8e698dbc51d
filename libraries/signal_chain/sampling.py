"""Sampling instants of the controller, which are independent of the communication step.

The instants are t_n = begin + n T with T = `sample_time`; `begin` is the time of the first step. The sample of an
instant is taken by the step [t, t + h) that contains it, with the inputs of that step. The currents are held until the
next sample:

    t_n           |               |               |               |
    h = T/4       *   .   .   .   *   .   .   .   *   .   .   .   *        * sample, . nothing changes
    h = 0.7 T     *          .          *          *          *            up to h before its instant

An instant at the end of a step belongs to the next step. Co-simulation masters round times: n h differs from t_n in its
last digits, and a sum of steps drifts by up to n^2 1e-16 h, which is 2e-5 h after a million steps. An instant in the
last `TOLERANCE` h of a step is therefore treated as if it were at the end of the step, and its sample is late by at
most `TOLERANCE` h. Other samples are early by up to h. If a sum has drifted further, samples are taken one step
earlier. If h = T, this loses no sample: a step takes at most one sample, and the next step takes the one that is still
due.

A step longer than T could contain two instants, but would have inputs only for the first.
"""

from __future__ import annotations

from fmi_export.jit import inlined_kernel

TOLERANCE = 1e-3  # of the communication step
LONGEST_STEP = 1.0 + 1e-9  # samples, for masters that round sample_time differently
ROUNDING = 4.5e-16  # relative to the time, from which a master computes the step by subtraction


@inlined_kernel
def is_due(instant: float, time: float, step_size: float) -> bool:
    """Return whether the step that begins at `time` takes the sample of an instant (all arguments in s)."""
    return instant < time + (1.0 - TOLERANCE) * step_size


@inlined_kernel
def is_too_long(time: float, step_size: float, sample_time: float) -> bool:
    """Return whether the step that begins at `time` is longer than the sample time, apart from rounding (all in s)."""
    return step_size > LONGEST_STEP * sample_time + ROUNDING * abs(time)
