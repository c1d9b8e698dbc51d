"""The strongest vibration in sampled motion that is not periodic with the rotation.

The spectrum of n samples over N turns, with a Hann window, has lines at k/N of the speed. A vibration covers five of
them, up to `LOBE` = 2 lines on either side of the strongest. The strongest line k that is farther than this from every
multiple of the speed, including 0, belongs to a vibration that rotation does not force. Its frequency f lies between
this line and its larger neighbour k + s:

    f N = k + s (2 r - 1)/(r + 1),    r = |W_(k+s)|/|W_k|                                         (1)

The amplitudes of the vibration are found by fitting it, together with the mean and the harmonics of the speed, to each
half of the samples. The fit separates frequencies that share lines.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from array_types import Array

LOBE = 2.0  # lines on either side of a vibration
HARMONICS = 4  # of the forced motion in the fit


class FreeVibration(NamedTuple):
    """Rms (m) of the vibration in the first and second halves of the samples, and of all motion in the second half."""

    before: float
    after: float
    total: float


def free_vibration(motion: Array, turns: float) -> FreeVibration | None:
    """Return the strongest vibration that is not periodic with the rotation; None if only harmonics of it exist.

    Parameters
    ----------
    motion
        Equally spaced samples of some signals (m), shape (n, signals).
    turns
        Turns of the rotor during these samples; 0 for a rotor that does not rotate.
    """
    n = len(motion)
    W = np.fft.rfft(np.hanning(n)[:, None] * (motion - motion.mean(axis=0)), axis=0)
    size, k = np.linalg.norm(W, axis=1), np.arange(len(W))
    multiples = np.round(k / turns) * turns if turns else 0.0
    free = np.where(np.abs(k - multiples) > LOBE, size, 0.0)[:-1]
    if not free.any():
        return None
    top = int(free.argmax())
    side = 1 if size[top + 1] > size[top - 1] else -1
    r = size[top + side] / size[top]
    own = top + side * (2.0 * r - 1.0) / (r + 1.0)
    orders = [own, *(turns * np.arange(1, HARMONICS + 1) if turns else ())]
    halves = [_fitted(motion[part], np.arange(n)[part] / n, orders) for part in (slice(n // 2), slice(n // 2, n))]
    return FreeVibration(halves[0][0], *halves[1])


def _fitted(motion: Array, share: Array, orders: list[float]) -> tuple[float, float]:
    """Return the rms of the vibration with the first of `orders` (periods per unit of `share`), and of all motion."""
    angles = 2.0 * np.pi * np.outer(share, orders)
    basis = np.concatenate(
        [np.cos(angles[:, :1]), np.sin(angles[:, :1]), np.cos(angles[:, 1:]), np.sin(angles[:, 1:])], axis=1
    )
    basis = np.concatenate([basis, np.ones((len(share), 1))], axis=1)
    amplitudes = np.linalg.lstsq(basis, motion, rcond=1e-9)[0]
    moving = motion - motion.mean(axis=0)
    return float(np.sqrt(0.5 * np.sum(amplitudes[:2] ** 2))), float(np.sqrt(np.sum(moving**2) / len(motion)))
