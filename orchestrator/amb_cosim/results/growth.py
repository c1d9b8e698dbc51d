"""The part of sampled motion that evidently grows, whatever its phase and number of periods.

Free motion of a linear machine, with its steady orbit, rest position and drift, is

    y(k) = sum_i c_i z_i^k + a + b k,    k = 0 ... n - 1                                          (1)

All signals share the poles z_i, which are the eigenvalues of a matrix pencil built from windows of the samples (Y. Hua,
T. K. Sarkar, Matrix pencil method for estimating parameters of exponentially damped/undamped sinusoids in noise, IEEE
Trans. Acoustics, Speech and Signal Processing 38 (1990) 814-824). The amplitudes c_i, a and b are fitted by least
squares. Sampling preserves |z_i| even of vibrations faster than half the sample rate.

Estimated poles of noise, of slow motion over less than a period, and of slightly non-linear motion may lie outside the
unit circle although nothing grows. Such poles explain next to nothing that poles on the circle would not explain too.
With the rms values

    s    of the motion about its mean
    r    of the residual of (1)
    r_1  of the residual with the poles outside the circle moved to it

growth is evident if

    r_1^2 > 3 r^2  and  r_1 > 0.02 s                                                              (2)

which is growth in noise, or, in motion that (1) describes almost exactly,

    r_1 > 2000 max(r, 1e-10 s)                                                                    (3)

The constants separate motions whose poles are known. Of 29 stable loops with linear and non-linear magnets and poles
down to -0.2 1/s, each cut at 31 ends, r_1 exceeds 0.006 s and 930 max(r, 1e-10 s) nowhere; synthetic vibrations that
grow by a factor of 1.5 or more reach 5600 max(r, 1e-10 s) even over a tenth of a period.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from amb_cosim.cosim.processes.blas import one_blas_thread
from array_types import Array, Complex

LEAST = 1e-3  # logarithm of the growth within the time, below which a pole counts as lying on the circle
IN_NOISE, OF_MOTION = 3.0, 0.02  # of (2)
EXACT, FLOOR = 2e3, 1e-10  # of (3)
SAMPLES = 160  # that are examined, at most
FEWEST = 12  # samples that are examined, at least
MOST_POLES, RANK = 24, 1e-8  # number, and singular value over the largest


class Growth(NamedTuple):
    """The largest part that grows: the logarithm of its growth within the time of the motion, and its periods.

    `periods` is None if samples were left out, since a vibration that is faster than half their rate is then aliased.
    """

    growth: float
    periods: float | None


def growing_part(motion: Array, rest: float) -> Growth | None:
    """Return the part of a motion that evidently grows and exceeds `rest` in the last third of the time, if any.

    Parameters
    ----------
    motion
        Equally spaced samples of some signals (m), shape (n, signals).
    rest
        Rms of a motion that counts as rest (m).
    """
    every = -(-len(motion) // SAMPLES)
    motion = motion[(len(motion) - 1) % every :: every]
    n = len(motion)
    if n < FEWEST or not np.ptp(motion, axis=0).max() > rest:
        return None
    with one_blas_thread():  # several threads wait for each other, 0.1 s on a busy machine
        z = _evident(motion - motion.mean(axis=0), rest)
    if z is None:
        return None
    return Growth(n * math.log(abs(z)), n * abs(float(np.angle(z))) / (2.0 * math.pi) if every == 1 else None)


def _evident(motion: Array, rest: float) -> complex | None:
    """Return the pole of the largest growing part, if growth about the mean is evident and exceeds `rest`."""
    n = len(motion)
    z = _poles(motion)
    growing = n * np.log(np.abs(z)) > LEAST
    if not growing.any():
        return None
    terms, amplitudes, r = _fit(z, motion)
    last = slice(n - n // 3, None)
    parts = terms[last, : len(z)][:, growing], amplitudes[: len(z)][growing]
    r_1 = _fit(np.where(growing, z / np.abs(z), z), motion)[2]
    s = _rms(motion)
    in_noise = r_1**2 > IN_NOISE * r**2 and r_1 > OF_MOTION * s
    if not (in_noise or r_1 > EXACT * max(r, FLOOR * s)) or not _rms(parts[0] @ parts[1]) > rest:
        return None
    sizes = np.linalg.norm(parts[0], axis=0) * np.linalg.norm(parts[1], axis=1)
    return complex(z[growing][sizes.argmax()])


def _rms(values: Array | Complex) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def _poles(motion: Array) -> Complex:
    """Return the poles z of (1), except poles that decay within a sample."""
    width = len(motion) // 3
    windows = [sliding_window_view(signal, len(motion) - width + 1) for signal in motion.T]
    triangle = np.asarray(np.linalg.qr(np.concatenate(windows, axis=1).T, mode="r"))
    U, s, _ = np.linalg.svd(triangle.T)  # equal to those of the windows, which have more columns
    U = U[:, : min(int(np.count_nonzero(s > RANK * s[0])), MOST_POLES, width - 1)]
    z = np.linalg.eigvals(np.linalg.lstsq(U[:-1], U[1:], rcond=None)[0]).astype(np.complex128)
    return z[np.abs(z) > RANK]


def _fit(z: Complex, motion: Array) -> tuple[Complex, Complex, float]:
    """Return the terms of (1) (scaled to 1 at the end if they grow), the amplitudes, and the rms of the residual."""
    n = len(motion)
    k = np.arange(n)[:, None]
    exponents = np.where(np.abs(z) > 1.0, k - (n - 1), k)
    terms = np.concatenate([np.exp(np.log(z) * exponents), np.ones((n, 1)), k / n], axis=1)
    amplitudes = np.linalg.lstsq(terms, motion.astype(np.complex128), rcond=1e-12)[0]
    return terms, amplitudes, _rms(motion - terms @ amplitudes)
