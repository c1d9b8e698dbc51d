"""Demands delayed by a whole number of samples and a fraction of one.

If the delay is d = n + f samples, 0 <= f < 1, the demand computed at sample s appears at the instant t_s + (n + f) T:

    v(t) = u_(s-n)     from t_s + f T on,   u_(s-n-1) before                          (1)

If f = 0, the demand applies to the whole communication step that takes sample s + n; this is also the rule without a
delay. Otherwise a communication step outputs the mean of v over the step. The mean equals v if v does not change within
the step; otherwise it gives the correct impulse of the force.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from linear_controller.interface import MAX_DELAY

N_HISTORY = int(MAX_DELAY) + 4  # samples: the newest, those of the delay including the chain's, and two before


@kernel
def fill(history: Array, demands: Array) -> None:
    """Fill `history`, shape (N_HISTORY, n_demands), with the demands before the first sample, shape (n_demands,)."""
    for k in range(history.shape[0]):
        for i in range(history.shape[1]):
            history[k, i] = demands[i]


@kernel
def store_demands(history: Array, sample: int, demands: Array) -> None:
    """Store the demands of a sample; `sample` is its number, from 0."""
    place = sample % N_HISTORY
    for i in range(history.shape[1]):
        history[place, i] = demands[i]


@kernel
def share_after(instant: float, time: float, step_size: float) -> float:
    """Return the fraction of a step that lies after an instant; the step begins at `time` (all arguments in s)."""
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
        Delay d, in samples.
    shares
        Fractions of the step that lie after two changes of v: the change due to the newest sample (at t_s + f T), and
        that due to the previous sample.
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
