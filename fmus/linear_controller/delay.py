"""Demands that come late by a whole number of samples and a part of one.

With a delay d = n + f, 0 <= f < 1, the demand that was computed at the sample s appears at the instant t_s + (n + f) T:

    v(t) = u_(s-n)     from t_s + f T on,   u_(s-n-1) before                          (1)

For f = 0 it appears with the sample's step, as without a delay. Otherwise a communication step shows the mean of v over
the step: v itself where no change falls into the step, and where one does, the impulse of the force is right.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from linear_controller.interface import MAX_DELAY

N_KEPT = int(MAX_DELAY) + 4  # samples: the newest, the delay with that of the chain, and two before it


@kernel
def fill(kept: Array, demands: Array) -> None:
    """Write the demands before the first sample, shape (n_demands,), into all places of `kept`, (N_KEPT, n_demands)."""
    for k in range(kept.shape[0]):
        for i in range(kept.shape[1]):
            kept[k, i] = demands[i]


@kernel
def keep(kept: Array, sample: int, demands: Array) -> None:
    """Keep the demands of a sample, from 0."""
    place = sample % N_KEPT
    for i in range(kept.shape[1]):
        kept[place, i] = demands[i]


@kernel
def share_after(instant: float, time: float, step_size: float) -> float:
    """Return the share of the step of `step_size` from `time` that comes after an instant (all in s)."""
    return min(max((time + step_size - instant) / step_size, 0.0), 1.0)


@kernel
def show(kept: Array, sample: int, delay: float, shares: tuple[float, float], shown: Array) -> None:
    """Write the mean of (1) over a step into `shown`, shape (n_demands,).

    Parameters
    ----------
    kept
        Demands, shape (N_KEPT, n_demands).
    sample
        Number of the newest sample, from 0.
    delay
        d, in samples.
    shares
        Of the step, after the changes that belong to the newest sample and to the one before.
    """
    whole = int(delay)
    newest = (sample - whole + N_KEPT) % N_KEPT
    before, oldest = (newest - 1 + N_KEPT) % N_KEPT, (newest - 2 + N_KEPT) % N_KEPT
    last, earlier = shares
    for i in range(shown.shape[0]):
        if last == 1.0:
            shown[i] = kept[newest, i]
        else:
            shown[i] = last * kept[newest, i] + (earlier - last) * kept[before, i] + (1.0 - earlier) * kept[oldest, i]
