"""Sampling instants of the controller, which are independent of the communication step.

The instants are t_n = begin + n T with T = `sample_time`; `begin` is the time of the first step. The sample of an
instant is taken by the step [t, t + h) that contains it, with the inputs of that step. The currents are held until the
next sample:

    t_n           |               |               |               |
    h = T/4       *   .   .   .   *   .   .   .   *   .   .   .   *        * sample, . nothing changes
    h = 0.7 T     *          .          *          *          *            up to h before its instant

An instant at the end of a step belongs to the next step. Co-simulation masters round times: n h differs from t_n in its
last digits, and a sum of steps drifts from it. Three rules keep this rounding from moving a sample to another step:

* If a step begins within the `rounding` of an instant, `begin` is moved so that the instant is the beginning of the
  step. The instants therefore follow the time of the master, and a drift does not add up.
* An instant in the last `TOLERANCE` h of a step, or within the `rounding` of its end, is treated as if it were at the
  end. Its sample is late by at most that time; other samples are early by up to h.
* A step may exceed T by the `rounding`. A longer step could contain two instants, but would have inputs only for the
  first.

`libraries/fmi_export/building/native/assembly.c` divides the steps of an assembly by the same rules.
"""

from __future__ import annotations

from fmi_export.jit import inlined_kernel

TOLERANCE = 1e-3  # of the communication step
ROUNDING = 1e-6  # of the sample time
ROUNDING_OF_TIME = 4.5e-16  # relative to the time: two units in its last place


@inlined_kernel
def rounding(time: float, step_size: float, sample_time: float) -> float:
    """Return the largest difference between an instant and the communication point that it stands for (all in s)."""
    return min(ROUNDING * sample_time + ROUNDING_OF_TIME * abs(time), 0.5 * step_size)


@inlined_kernel
def aligned(begin: float, n_samples: float, time: float, step_size: float, sample_time: float) -> float:
    """Return `begin` (s), moved by the rounding if the step begins at an instant.

    Parameters
    ----------
    begin
        Time of the first sample (s); without meaning before it.
    n_samples
        Number of samples taken so far.
    time, step_size, sample_time
        Beginning and size of the step, and time between samples (s).
    """
    late = time - (begin + n_samples * sample_time)
    if n_samples == 0.0 or abs(late) <= rounding(time, step_size, sample_time):
        return time - n_samples * sample_time
    return begin


@inlined_kernel
def is_due(instant: float, time: float, step_size: float, sample_time: float) -> bool:
    """Return whether the step that begins at `time` takes the sample of an instant (all arguments in s)."""
    return instant < time + step_size - max(TOLERANCE * step_size, rounding(time, step_size, sample_time))


@inlined_kernel
def is_too_long(time: float, step_size: float, sample_time: float) -> bool:
    """Return whether the step that begins at `time` is longer than the sample time, apart from rounding (all in s)."""
    return step_size > sample_time + rounding(time, step_size, sample_time)
