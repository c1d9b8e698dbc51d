"""Blows of a hammer in a record, and the blocks of the record that contain the responses to them.

A hammer pushes for a short time, in one direction, and then rests. Let u be a force without its median, and sigma the
standard deviation of its noise. A hammer acts at the samples where

    |u| > max(0.05 max|u|, 6 sigma),   sigma = 1.4826 median|u|                                     (1)

A record contains blows if (1) holds for few samples, if 6 sigma is far below max|u|, and if each blow pushes in one
direction, |sum u| > 0.7 sum|u|. A shaker or a sweep, even with pauses, violates one of these conditions. Pulses that
follow each other much faster than the others are rebounds of one blow.

A block begins shortly before a blow and ends before the next one, or when 0.1 % of the response is left, because the
rest of the block would add only noise. The decay below the noise is extrapolated. If the fraction e of a vibration is
left at the end of a block, its residue changes by a factor of about 1 - e. Its pole does not change, because exp(-j
omega T) = 1 at the lines of a block of length T. If more than 0.2 % is left, the force and the responses are multiplied
by

    w(t) = exp(-t/tau),   tau = T/ln(100)                                                           (2)

For a block that begins at rest this gives exactly H(j omega + 1/tau) in place of
H(j omega): all vibrations decay faster by 1/tau. The force is set to zero where no hammer acts, because there it is
noise.

The coherence of a single blow is 1 at all frequencies, whatever the noise. It is therefore computed from the spectra
N_uu and N_yy of the noise outside the block,

    gamma^2 = (1 - N_uu/S_uu)(1 - N_yy/S_yy)                                                        (3)

D. J. Ewins, Modal Testing, 2nd ed., Research Studies Press, 2000, sec. 3.9; J. S. Bendat, A. G. Piersol, Random Data,
4th ed., Wiley, 2010, sec. 6.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.ndimage import find_objects, label, uniform_filter1d
from scipy.signal import welch

from amb_analysis.measured.force_noise import ForceNoise
from array_types import Array, Bools, Complex, Indices

ACTING, NOISE = 0.05, 6.0  # of (1)
CLEAR = 0.3  # largest 6 sigma over max|u|
MOST_ACTING = 0.15  # of the samples
ONE_SIDED = 0.7  # least |sum u|/sum|u| of a blow
REBOUND, SHORT = 0.15, 0.4  # longest time (s) to a rebound, and largest ratio of this time to other intervals
RINGING = 3.0  # times the length of a pulse, after which another one is a rebound
COMPLETE = 0.2  # of the peak of a blow, above which the first sample of a record lies within the blow
LEAST_REST = 0.8  # of the shortest interval, which must follow the last blow
WINDOWS, LEAST_WINDOW = 32, 16  # parts of a block in which the decay is observed, and their least length in samples
LEFT = 2e-3  # amplitude at the end of a block over the initial one, up to which no exponential window is required
DECAYED = 0.01  # exp(-T/tau) of (2)
FLOOR = 4.0  # ratio of powers, within which the rest of a record is noise
NOISY = 0.04  # power over the initial one, above which it is not called noise
FLAT, LEAST_FLAT = 1.3, 8  # ratio of the powers in both halves of the rest, above which it decays; its fewest parts
CALM, BEYOND = 1.25, 1.6  # times in which the response decays to the level of the noise: noise alone; end of a block
HEARD, REMAINS = 0.2, 1e-3  # amplitudes over the initial one: largest that counts as noise; at the end of a block
SILENT = 1e-6  # power over the initial one, below which nothing is left
LEAST_QUIET = 64  # samples from which noise is estimated
NOISE_SEGMENTS = 16  # of a quiet part, over which the spectrum of its noise is averaged
SMOOTHED = 5  # lines over which the power in (3) is averaged, because a single line of noise has a large scatter
EXCITED = 0.01  # power of the force over its maximum, where it still excites: -20 dB


@dataclass(frozen=True, eq=False)
class Blows:
    """Blows in a record.

    starts
        First sample of the block of each blow, shape (blows,).
    rests
        Number of samples from each start to the next block or the end of the record, shape (blows,).
    acting
        Samples at which a hammer acts, shape (samples,).
    rebounds
        Number of blows that have rebounds.
    incomplete
        Whether the record begins within its only blow.
    """

    starts: Indices
    rests: Indices
    acting: Bools
    rebounds: int
    incomplete: bool

    @property
    def available(self) -> int:
        """Number of samples of the longest blocks, of which none contains two blows."""
        return int(self.rests.min())

    def lasting(self, n: int) -> Blows:
        """Return the blows with at least `n` samples before the next one; those with fewer samples are left out."""
        kept = self.rests >= n
        return replace(self, starts=self.starts[kept], rests=self.rests[kept])


def find_blows(forces: Array, sample_time: float) -> Blows | None:
    """Return the blows in a record, or None if its forces are not those of a hammer.

    Parameters
    ----------
    forces
        Inputs, shape (inputs, repeats, samples); a blow and its response lie within one repeat.
    sample_time
        Sample time (s).
    """
    repeats, n = forces.shape[1:]
    u = forces - np.median(forces, axis=2, keepdims=True)
    sigma = 1.4826 * np.median(np.abs(u), axis=(1, 2))[:, None, None]
    peaks = np.abs(u).max(axis=2, keepdims=True)
    highest = peaks.max(axis=1, keepdims=True)
    if not (highest > 0.0).all() or (NOISE * sigma > CLEAR * highest).any():
        return None
    over = np.abs(u) > np.maximum(np.maximum(ACTING * peaks, NOISE * sigma), ACTING**2 * highest)
    active = over.any(axis=0)
    if not active.any() or active.mean() > MOST_ACTING:
        return None
    pulses = [
        (k * n + run.start, k * n + run.stop) for k, row in enumerate(active) for (run,) in find_objects(label(row)[0])
    ]
    groups = _groups(pulses, n, REBOUND / sample_time)
    pushes = np.where(over, u, 0.0).reshape(len(u), -1)
    for group in groups:
        push = pushes[:, group[0][0] : group[-1][1]]
        if (np.abs(push.sum(axis=1)) < ONE_SIDED * np.abs(push).sum(axis=1)).any():
            return None
    acting = np.zeros(repeats * n, np.bool_)
    for first, last in pulses:
        margin, begin = (last - first) // 4 + 1, first - first % n
        acting[max(first - margin, begin) : min(last + margin, begin + n)] = True
    sizes = (np.abs(u) / highest).max(axis=0).ravel()
    return _placed(groups, acting, sizes, n)


def _groups(pulses: list[tuple[int, int]], n: int, rebound: float) -> list[list[tuple[int, int]]]:
    """Return the pulses (first and last sample) of each blow; `n` is the length of a repeat."""
    firsts = [pulse[0] for pulse in pulses]
    following = [
        min(after, first - first % n + n) - first for first, after in zip(firsts, [*firsts[1:], np.inf], strict=True)
    ]
    limit = min(rebound, SHORT * max(following))
    for _ in range(2):
        groups = [[pulses[0]]]
        for pulse in pulses[1:]:
            same = pulse[0] // n == groups[-1][0][0] // n and pulse[0] - groups[-1][0][0] < limit
            if same:
                groups[-1].append(pulse)
            else:
                groups.append([pulse])
        gaps = [b[0][0] - a[0][0] for a, b in pairwise(groups) if a[0][0] // n == b[0][0] // n]
        limit = max(limit, SHORT * float(np.median(gaps))) if gaps else limit
    return groups


def _has_rebound(group: list[tuple[int, int]]) -> bool:
    """Return whether a pulse follows the first one after some time, other than the ringing of a filter."""
    first, last = group[0]
    return any(pulse[0] - last > RINGING * (last - first) for pulse in group[1:])


def _placed(groups: list[list[tuple[int, int]]], acting: Bools, sizes: Array, n: int) -> Blows | None:
    """Return the blows with their blocks, without those that the ends of the record cut; None if none is left."""
    widest = max(last - first for group in groups for first, last in group)
    firsts = np.array([group[0][0] for group in groups])
    begins = firsts - firsts % n
    starts = np.maximum(firsts - 2 * widest - 2, begins)
    after = np.append(starts[1:], np.inf)
    rests = np.minimum(after, begins + n) - starts
    is_last = after >= begins + n
    cut = np.array([first == begin and sizes[first] > COMPLETE * sizes[g[0][0] : g[0][1]].max()
                    for g, first, begin in zip(groups, firsts, begins, strict=True)])  # fmt: skip
    usual = float(rests[~is_last].min() if (~is_last).any() else np.median(rests))
    kept = ~is_last | (rests >= LEAST_REST * usual)
    incomplete = bool(cut[kept].all())
    kept &= ~cut | incomplete
    rebounds = sum(_has_rebound(group) for group, k in zip(groups, kept, strict=True) if k)
    return Blows(starts[kept], rests[kept].astype(np.intp), acting, rebounds, incomplete)


def decay(outputs: Array, blows: Blows) -> tuple[int, float, int]:
    """Return the number of samples after which the response to a blow is noise, and the amplitude left there.

    The power of the response in parts of the block, relative to that after the blow, falls to a constant value, which
    is noise. If it falls until the end of the block, all of the block is needed.

    Parameters
    ----------
    outputs
        Responses, shape (outputs, samples).
    blows
        The blows in the record.

    Returns
    -------
    samples, left, heard
        The length, at most `blows.available`. The amplitude is relative to that after the blow, for the output with the
        slowest decay; 0 if the block ends with only 0.1 % left. The last is the number of samples after which only
        noise is left.
    """
    n = blows.available
    while True:
        size = max(n // WINDOWS, 1)
        parts = np.stack([outputs[:, s : s + size * (n // size)].reshape(len(outputs), -1, size) for s in blows.starts])
        power = np.mean(np.var(parts, axis=3), axis=0)
        power = power / np.maximum(power.max(axis=1, keepdims=True), np.finfo(float).tiny)
        falling = power[power.min(axis=1) <= NOISY / FLOOR]
        r = (falling if len(falling) else power).max(axis=0)
        floor = FLOOR * float(r.min())
        over = np.flatnonzero(r > max(floor if floor <= NOISY else 0.0, SILENT))
        m = int(over[-1]) + 1 if len(over) else 1
        rest = r[round(CALM * m) :]
        half = len(rest) // 2
        ends = len(rest) >= LEAST_FLAT and float(rest[:half].mean()) < max(FLAT * float(rest[-half:].mean()), SILENT)
        if not ends:
            return blows.available, float(np.sqrt(r[-1])), blows.available
        if m > 2 or size < 2 * LEAST_WINDOW:
            heard = min(float(np.sqrt(max(floor, SILENT))), HEARD)  # amplitude after m parts
            needed = round(max(BEYOND, np.log(REMAINS) / np.log(heard)) * m * size)
            left = 0.0 if needed <= blows.available else float(heard ** (blows.available / (m * size)))
            return min(needed, blows.available), left, round(CALM * m * size)
        n = 4 * size


def block_transforms(rows: Array, inputs: int, blows: Blows, n: int, rate: float) -> Complex:
    """Return the Fourier transform of each channel in each block, shape (blows, channels, n//2 + 1).

    Parameters
    ----------
    rows
        Inputs followed by outputs, shape (channels, samples), without offsets.
    inputs
        Number of inputs.
    blows, n
        The blows, and the number of samples of a block.
    rate
        1/tau of the exponential window (2), times the sample time (1); 0 for none.
    """
    forced = rows.copy()
    forced[:inputs, ~blows.acting] = 0.0
    return np.stack([rfft(forced[:, s : s + n] * np.exp(-rate * np.arange(n)), axis=1) for s in blows.starts])


def force_noise(force: Array, U: Complex, blows: Blows, n: int, rate: float, step: float) -> ForceNoise | None:
    """Return the noise of the only force; None if no sample shows it, because the hammer acts all the time.

    Parameters
    ----------
    force, U
        The force, shape (samples,), and its transform in each block, shape (blows, n//2 + 1).
    blows, n, rate
        As for `block_transforms`.
    step
        Sample time (s).
    """
    if blows.acting.all():
        return None
    at = [np.flatnonzero(blows.acting[s : s + n]) for s in blows.starts]
    samples = np.concatenate(at)
    return ForceNoise(
        np.asarray(samples * step, np.float64),
        float(np.std(force[~blows.acting])) * np.exp(-rate * samples),
        np.repeat(np.arange(len(at)), [len(of_blow) for of_blow in at]),
        (U.conj() / np.maximum(np.sum(np.abs(U) ** 2, axis=0), np.finfo(float).tiny)).T,
    )


def noise_spectra(rows: Array, n: int, inputs: int, blows: Blows, rate: float, quiet: slice | None) -> Array | None:
    """Return the spectra of the noise in a block, shape (n//2 + 1, channels); None if the record has no quiet part.

    Parameters
    ----------
    rows, n, inputs, blows, rate
        As for `block_transforms`.
    quiet
        Samples that contain only noise; None if there are none.
    """
    if quiet is None:
        return None
    lasts = quiet.stop - quiet.start
    length = min(n, max(lasts // NOISE_SEGMENTS, LEAST_QUIET // 2))
    at, density = welch(rows[:, quiet], 1.0, nperseg=length)
    weights = np.exp(-2.0 * rate * np.arange(n))
    acting = np.mean([weights @ blows.acting[s : s + n] for s in blows.starts])
    energies = np.where(np.arange(len(rows)) < inputs, acting, float(weights.sum()))
    lines = rfftfreq(n)
    return np.stack([np.interp(lines, at, 0.5 * d * e) for d, e in zip(density, energies, strict=True)], axis=1)


def noise_coherence(S: Complex, inputs: int, noise: Array) -> Array:
    """Return the coherence (3) of each output, shape (n//2 + 1, outputs), from the spectra with and of the noise."""
    power = uniform_filter1d(np.einsum("nkk->nk", S).real, SMOOTHED, axis=0)
    shares = 1.0 - noise / np.maximum(power, np.finfo(float).tiny)
    of_input = np.clip(shares[:, :inputs], 0.0, 1.0).prod(axis=1, keepdims=True)
    return np.asarray(of_input * np.clip(shares[:, inputs:], 0.0, 1.0))


def offsets(rows: Array, quiet: slice | None, n: int) -> Array:
    """Return the mean of each channel over at least `n` quiet samples, or else its median, shape (channels, 1)."""
    is_long = quiet is not None and quiet.stop - quiet.start >= n
    return np.asarray(rows[:, quiet].mean(axis=1) if is_long else np.median(rows, axis=1))[:, None]


def quiet_part(blows: Blows, heard: int) -> slice | None:
    """Return the longest part of a record that is more than `heard` samples after each blow; None if it is short."""
    busy = blows.acting.copy()
    for (run,) in find_objects(label(blows.acting)[0]):
        busy[run.start : run.start + heard] = True
    parts = [run for (run,) in find_objects(label(~busy)[0])]
    longest = max(parts, key=lambda run: run.stop - run.start, default=slice(0, 0))
    return longest if longest.stop - longest.start >= LEAST_QUIET else None
