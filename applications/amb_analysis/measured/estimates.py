"""Frequency responses and coherence from records of inputs and outputs, by averaged spectra (P. D. Welch).

If the inputs are blows of a hammer, there is a segment for each blow (`blows`). Otherwise, segments of equal length
divide the record, and each is multiplied by a window.

The averaged spectra of segments, S_uu = <U U^H>, S_yu = <Y U^H> and S_yy = <Y Y^H>, give

    H1 = S_yu S_uu^-1                  noise at the outputs averages out                             (1)
    H2 = S_yy S_uy^-1                  noise at the input averages out, one input                    (2)
    gamma^2 = S_yu S_uu^-1 S_uy/S_yy   coherence; multiple coherence if there are several inputs    (3)

J. S. Bendat, A. G. Piersol, Random Data, 4th ed., Wiley, 2010.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.signal import csd, get_window

from amb_analysis.measured.blows import (
    DECAYED,
    EXCITED,
    LEFT,
    Blows,
    block_transforms,
    find_blows,
    force_noise,
    noise_coherence,
    noise_spectra,
    offsets,
    quiet_part,
)
from amb_analysis.measured.blows import decay as ending
from amb_analysis.measured.force_noise import ForceNoise
from amb_analysis.measured.records import Estimate, FrequencyResponse, TimeRecord, check_sizes
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_files.checks import require_choice
from array_types import Array, Complex

Estimator = Literal["H1", "H2"]
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)

SEGMENTS = 8  # without overlap, by default
LEAST_SAMPLES = 8  # of a segment
BOXCAR, EXPONENTIAL = "boxcar", "exponential"
NAMES = {name: BOXCAR for name in ("rect", "rectangular", "box", "ones")} | {"poisson": EXPONENTIAL}


def estimate(
    record: TimeRecord,
    inputs: Sequence[str],
    *,
    estimator: Estimator = "H1",
    segment: float | None = None,
    window: str | None = None,
    decay: float = 0.0,
) -> tuple[FrequencyResponse, ...]:
    """Return the response of each output to each input with its coherence, by (1) to (3).

    Parameters
    ----------
    record
        Signals over time.
    inputs
        Names of the input channels; all other channels are outputs.
    estimator
        `H1`, or `H2` if there is only one input.
    segment
        Length of a segment (s). For blows the default is the time in which the response decays, or the shortest time
        between blows. Otherwise it is an eighth of the record. The frequency resolution is the inverse of this length.
        Segments overlap by half of their length, unless the window is `boxcar` or there are blows.
    window
        Name of a window. For blows it is `boxcar`, or `exponential` if the response has not decayed at the end of a
        segment; by default the record decides. Otherwise it is a SciPy window, by default `hann`. With another window,
        blows are not treated as such.
    decay
        Rate 1/tau (1/s) of the window `exponential`; by default the window decays to 1 % within a segment.

    Raises
    ------
    ValueError
        If a channel, window or length is not allowed, if a signal contains numbers that are not finite, or if inputs
        are linearly dependent.
    """
    input_channels = [record.channel(name) for name in dict.fromkeys(inputs)]
    if not input_channels:
        raise ValueError("an estimate needs an input; name one of " + ", ".join(c.name for c in record.signals))
    output_channels = [c for c in record.signals if c not in input_channels]
    if not output_channels:
        raise ValueError("an estimate needs an output; all channels of the record are inputs")
    require_choice("estimator", estimator, ESTIMATORS)
    if estimator == "H2" and len(input_channels) > 1:
        raise ValueError("estimator H2 is not allowed with several inputs; use H1")
    for channel in (*input_channels, *output_channels):
        if not np.isfinite(record.signals[channel]).all():
            raise ValueError(f"channel {channel.name} contains numbers that are not finite")
        check_sizes(record.signals[channel], f"channel {channel.name}")
    window = None if window is None else NAMES.get(window, window)
    if decay and window not in (None, EXPONENTIAL):
        raise ValueError(
            f"an exponential window is not allowed together with the window {window!r}; choose one of them"
        )
    rows = np.stack([record.signals[c] for c in (*input_channels, *output_channels)])
    count = len(input_channels)
    blows = None
    if window in (None, BOXCAR, EXPONENTIAL):
        blows = find_blows(rows[:count].reshape(count, record.repeats, -1), record.sample_time)
    if blows is not None:
        spectra = _from_blows(rows, count, record.sample_time, blows, segment, window, decay)
    elif decay or window == EXPONENTIAL:
        raise ValueError(
            f"the window 'exponential' is not allowed, because {' and '.join(c.name for c in input_channels)} contains "
            "no blows of a hammer; the window must be symmetric, such as 'hann'"
        )
    else:
        n = _samples(record, segment)
        spectra = _from_segments(rows.reshape(len(rows), record.repeats, -1), record.sample_time, n, window or "hann")
    values, coherence = responses(spectra.S, count, estimator)
    gamma = spectra.coherence
    if gamma is None and spectra.estimate.blocks > 1:
        gamma = coherence
    return tuple(
        FrequencyResponse(
            output,
            source,
            spectra.frequencies,
            values[:, k, j],
            None if gamma is None else gamma[:, k],
            spectra.resolution,
            spectra.estimate.decay,
            spectra.estimate,
            None if spectra.scatter is None else spectra.scatter[:, k],
            spectra.force_noise,
        )
        for k, output in enumerate(output_channels)
        for j, source in enumerate(input_channels)
    )


def responses(S: Complex, inputs: int, estimator: Estimator = "H1") -> tuple[Complex, Array]:
    """Return the responses, shape (n, outputs, inputs), and the coherence of each output, shape (n, outputs).

    Parameters
    ----------
    S
        Spectra S_ij = <W_i W_j^*> of the inputs followed by the outputs, shape (n, channels, channels).
    inputs
        Number of inputs.
    estimator
        `H1` for (1), or `H2` for (2) if there is only one input.

    Raises
    ------
    ValueError
        If, at some frequency, an input is zero or is a linear combination of the other inputs.
    """
    S_uu, S_yu = S[:, :inputs, :inputs], S[:, inputs:, :inputs]
    S_yy = np.einsum("nkk->nk", S[:, inputs:, inputs:]).real
    size = np.sqrt(np.einsum("nkk->nk", S_uu).real)
    scaled = S_uu / np.maximum(size[:, :, None] * size[:, None, :], np.finfo(float).tiny)
    if (np.linalg.svd(scaled, compute_uv=False)[:, -1] < 1e-9).any():
        raise ValueError("an input is zero or depends on the others at some frequencies; responses cannot be separated")
    H1 = np.linalg.solve(S_uu.swapaxes(1, 2), S_yu.swapaxes(1, 2)).swapaxes(1, 2)
    explained = np.einsum("nkj,nkj->nk", H1, S_yu.conj()).real
    coherence = np.clip(explained / np.maximum(S_yy, np.finfo(float).tiny), 0.0, 1.0)
    if estimator == "H2":
        H1 = H1 / np.maximum(coherence, np.finfo(float).eps)[:, :, None]
    return np.asarray(H1), coherence


def _samples(record: TimeRecord, segment: float | None) -> int:
    samples = min(len(values) for values in record.signals.values())
    longest = samples // max(2, record.repeats)
    n = min(samples // SEGMENTS, longest) if segment is None else round(in_steps(segment, record.sample_time))
    if not LEAST_SAMPLES <= n <= longest:
        limits = f"{LEAST_SAMPLES * record.sample_time:g} s to {longest * record.sample_time:g} s"
        raise ValueError(f"a segment of {n * record.sample_time:g} s is not allowed; it must be {limits}")
    return n


class Spectra(NamedTuple):
    """Spectra at frequencies (Hz) above 0, how they were estimated, and their noise.

    resolution
        Width (Hz) of the window.
    coherence, scatter
        Coherence and squared scatter of each output, shape (n, outputs), from a quiet part of the record.
    force_noise
        Noise of the force of blows.
    """

    frequencies: Array
    S: Complex
    estimate: Estimate
    resolution: float | None = None
    coherence: Array | None = None
    scatter: Array | None = None
    force_noise: ForceNoise | None = None


def _from_blows(
    rows: Array, inputs: int, step: float, blows: Blows, segment: float | None, window: str | None, decay: float
) -> Spectra:
    """Return the spectra of the blocks of blows; rows have the shape (channels, samples)."""
    natural, left, heard = ending(rows[inputs:], blows)
    n = natural
    if segment is not None:
        n = round(in_steps(segment, step))
        longest = int(blows.rests.max())
        if not LEAST_SAMPLES <= n <= longest:
            limits = f"{LEAST_SAMPLES * step:g} s to {longest * step:g} s, the longest time after a blow"
            raise ValueError(f"a segment of {n * step:g} s is not allowed; it must be {limits}")
        blows = blows.lasting(n)
    elif n < LEAST_SAMPLES:
        raise ValueError(f"the blows are only {n * step:g} s apart; at least {LEAST_SAMPLES * step:g} s are required")
    if not decay and (window == EXPONENTIAL or (window is None and (left > LEFT or n < natural))):
        decay = float(-np.log(DECAYED)) / (n * step)
    n -= n % 2
    # What is left of a vibration is small beside the noise, but not in a narrow band about its frequency.
    quiet = quiet_part(blows, max(natural, heard)) or quiet_part(blows, heard)
    rows = rows - offsets(rows, quiet, n)
    W = block_transforms(rows, inputs, blows, n, decay * step)
    S = np.einsum("kin,kjn->nij", W, W.conj()) / len(W)
    power = np.einsum("nkk->kn", S[:, :inputs, :inputs]).real
    frequencies = np.arange(n // 2 + 1) / (n * step)
    excited = (power >= EXCITED * power.max(axis=1, keepdims=True)).all(axis=0)
    highest = float(frequencies[np.flatnonzero(excited)[-1]])
    quiet_noise = noise_spectra(rows, n, inputs, blows, decay * step, quiet)
    name, count = EXPONENTIAL if decay else BOXCAR, len(blows.starts)
    known = noise_coherence(S, inputs, quiet_noise) if quiet_noise is not None and count == 1 else None
    scatter = None
    if quiet_noise is not None and inputs == 1:
        scatter = quiet_noise[:, 1:] / np.maximum(count * power.T, np.finfo(float).tiny)
    noise = force_noise(rows[0], W[:, 0], blows, n, decay * step, step) if inputs == 1 else None
    lines = np.arange(1, n // 2)
    estimate = Estimate(name, count, n * step, decay, count, blows.rebounds, highest, left, blows.incomplete)
    return Spectra(
        frequencies[lines],
        S[lines],
        estimate,
        coherence=None if known is None else known[lines],
        scatter=None if scatter is None else scatter[lines],
        force_noise=None if noise is None else noise.at(lines),
    )


def _from_segments(rows: Array, step: float, n: int, window: str) -> Spectra:
    """Return the spectra of segments; rows have the shape (channels, repeats, samples).

    No segment extends over two repeats.
    """
    try:
        weights = get_window(window, n)
    except ValueError as error:
        raise ValueError(f"window {window!r} is not allowed: {error}") from error
    overlap = 0 if window == BOXCAR else n // 2
    # scipy's csd(x, y) averages X^* Y
    frequencies, S = csd(rows[None], rows[:, None], 1.0 / step, weights, n, overlap, detrend="constant")
    inner = slice(1, -1 if n % 2 == 0 else None)
    blocks = rows.shape[1] * ((rows.shape[2] - overlap) // (n - overlap))
    estimate = Estimate(window, blocks, n * step)
    return Spectra(frequencies[inner], np.moveaxis(S.mean(axis=2), -1, 0)[inner], estimate, 1.0 / (n * step))
