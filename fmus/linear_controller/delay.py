"""Demands delayed by a whole number of samples and a fraction of one.

With a delay d = n + f, 0 <= f < 1, the demand computed at sample s appears at the instant t_s + (n + f) T:

    v(t) = u_(s-n)     from t_s + f T on,   u_(s-n-1) before                          (1)

For f = 0 it appears in the sample's own step, as it would without a delay. Otherwise a communication step outputs the
mean of v over the step. This is v itself if it does not change within the step; if it does, the mean gives the correct
impulse of the force.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from linear_controller.interface import MAX_DELAY

N_HISTORY = int(MAX_DELAY) + 4  # samples: the newest, those of the delay including the chain's, and two before


@kernel
def fill(history: Array, demands: Array) -> None:
    """Write the demands before the first sample, (n_demands,), to all of `history`, (N_HISTORY, n_demands)."""
    for k in range(history.shape[0]):
        for i in range(history.shape[1]):
            history[k, i] = demands[i]


@kernel
def store_demands(history: Array, sample: int, demands: Array) -> None:
    """Store the demands of a sample, whose number counts from 0."""
    place = sample % N_HISTORY
    for i in range(history.shape[1]):
        history[place, i] = demands[i]


@kernel
def share_after(instant: float, time: float, step_size: float) -> float:
    """Return the fraction of a step, of length `step_size` from `time`, that lies after an instant (all in s)."""
    return min(max((time + step_size - instant) / step_size, 0.0), 1.0)


@kernel
def write_delayed(history: Array, sample: int, delay: float, shares: tuple[float, float], output: Array) -> None:
    """Write the mean of (1) over a step into `output`, shape (n_demands,).

    Parameters
    ----------
    history
        Demands, shape (N_HISTORY, n_demands).
    sample
        Number of the newest sample, from 0.
    delay
        d, in samples.
    shares
        Shares of the step after the changes that belong to the newest sample and to the previous one.
    """
    whole = int(delay)
    newest = (sample - whole + N_HISTORY) % N_HISTORY
    before, oldest = (newest - 1 + N_HISTORY) % N_HISTORY, (newest - 2 + N_HISTORY) % N_HISTORY
    last, earlier = shares
    for i in range(output.shape[0]):
        if last == 1.0:
            output[i] = history[newest, i]
        else:
            output[i] = (
                last * history[newest, i] + (earlier - last) * history[before, i] + (1.0 - earlier) * history[oldest, i]
            )
