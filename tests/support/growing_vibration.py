"""How a signal leaves a state: its growth rate, and the frequency of its vibration, without any model of the cause."""

import numpy as np


def growth_of(signal, step, frequency):
    """Return growth rate (1/s) and frequency (rad/s) of one vibration about zero, by linear prediction.

    d(n+2) = a d(n+1) - b d(n) every quarter of a period; of one that does not swing, the slope of its logarithm.
    `frequency` (rad/s) only says how far to look ahead.
    """
    if frequency < 1e-6:
        return np.polyfit(step * np.arange(len(signal)), np.log(np.abs(signal)), 1)[0], 0.0
    n = max(1, round(0.5 * np.pi / (frequency * step)))
    d = signal[n:] - signal[:-n]  # without its mean
    a, b = np.linalg.lstsq(np.stack([d[n:-n], -d[: -2 * n]], axis=1), d[2 * n :], rcond=None)[0]
    root = np.log(complex(np.roots([1.0, -a, b])[0])) / (n * step)
    return root.real, abs(root.imag)
