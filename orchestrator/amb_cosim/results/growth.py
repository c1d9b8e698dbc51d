"""Whether sampled motion contains a part that grows exponentially, whatever its phase and number of periods.

Free motion of a linear machine, with its steady orbit, rest position and drift, is

    y(k) = sum_i c_i z_i^k + a + b k,    k = 0 ... n - 1                                          (1)

All signals share the poles z_i, which are the eigenvalues of a matrix pencil built from windows of the samples (Y. Hua,
T. K. Sarkar, Matrix pencil method for estimating parameters of exponentially damped/undamped sinusoids in noise, IEEE
Trans. Acoustics, Speech and Signal Processing 38 (1990) 814-824). The amplitudes c_i, a and b are fitted by least
squares. Sampling preserves |z_i| even of vibrations faster than half the sample rate.

A pole counts as growing if it multiplies the mean square by more than 1.5 from the first third of the time to the last,
that is, if |z_i|^n > 1.5^(3/4). Noise, and slow motion over less than a period, can be fitted equally well by a growing
pole and by another pole. Growth therefore counts only if moving the growing poles to the unit circle increases the mean
square of the residual of (1) by a factor of more than 1.5.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from amb_cosim.cosim.processes.blas import one_blas_thread
from array_types import Array, Complex

GROWTH = 1.5  # of the mean square from the first to the last third
NEEDED = 1.5  # ratio of the residuals' mean squares, without growing poles over with them
SAMPLES = 160  # that are examined, at most
FEWEST = 12  # samples that are examined, at least
MOST_POLES, RANK = 24, 1e-8  # number, and singular value over the largest


def grows(motion: Array, rest: float) -> bool:
    """Return whether a part of the motion grows according to (1) and exceeds `rest` in the last third of the time.

    Parameters
    ----------
    motion
        Equally spaced samples of some signals (m), shape (n, signals).
    rest
        Rms of a motion that counts as rest (m).
    """
    motion = motion[(len(motion) - 1) % -(-len(motion) // SAMPLES) :: -(-len(motion) // SAMPLES)]
    n = len(motion)
    if n < FEWEST or not np.ptp(motion, axis=0).max() > rest:
        return False
    with one_blas_thread():  # several threads wait for each other, 0.1 s on a busy machine
        return _has_growing_part(motion - motion.mean(axis=0), rest)


def _has_growing_part(motion: Array, rest: float) -> bool:
    """Return whether the motion about its mean contains a growing part that exceeds `rest`."""
    n = len(motion)
    z = _poles(motion)
    growing = n * np.log(np.abs(z)) > 0.75 * math.log(GROWTH)
    if not growing.any():
        return False
    terms, amplitudes, residual = _fit(z, motion)
    part = terms[:, : len(z)][:, growing] @ amplitudes[: len(z)][growing]
    steady_residual = _fit(np.where(growing, z / np.abs(z), z), motion)[2]
    return bool(np.mean(np.abs(part[-(n // 3) :]) ** 2) > rest**2 and steady_residual > NEEDED * residual)


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
    """Return the terms of (1) (scaled to 1 at the end if they grow), the amplitudes, and the residual's mean square."""
    n = len(motion)
    k = np.arange(n)[:, None]
    exponents = np.where(np.abs(z) > 1.0, k - (n - 1), k)
    terms = np.concatenate([np.exp(np.log(z) * exponents), np.ones((n, 1)), k / n], axis=1)
    amplitudes = np.linalg.lstsq(terms, motion.astype(np.complex128), rcond=1e-12)[0]
    return terms, amplitudes, float(np.mean(np.abs(motion - terms @ amplitudes) ** 2))
