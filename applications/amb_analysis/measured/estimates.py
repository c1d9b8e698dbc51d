"""Frequency responses and coherence from records of inputs and outputs, by averaged spectra (P. D. Welch).

The averaged spectra of segments, S_uu = <U U^H>, S_yu = <Y U^H> and S_yy = <Y Y^H>, give

    H1 = S_yu S_uu^-1                  noise at the outputs averages out                             (1)
    H2 = S_yy S_uy^-1                  noise at the input averages out, one input                    (2)
    gamma^2 = S_yu S_uu^-1 S_uy/S_yy   coherence; multiple coherence if there are several inputs    (3)

J. S. Bendat, A. G. Piersol, Random Data, 4th ed., Wiley, 2010.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.signal import csd, get_window

from amb_analysis.measured.records import FrequencyResponse, TimeRecord, check_sizes
from amb_cosim.cosim.grid.time_grid import in_steps
from array_types import Array, Complex

Estimator = Literal["H1", "H2"]

SEGMENTS = 8  # without overlap, by default
LEAST_SAMPLES = 8  # of a segment


def estimate(
    record: TimeRecord,
    inputs: Sequence[str],
    *,
    estimator: Estimator = "H1",
    segment: float | None = None,
    window: str = "hann",
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
        Length of a segment (s); by default an eighth of the record. The frequency resolution is the inverse of this
        length. Segments overlap by half of their length, unless the window is `boxcar`.
    window
        Name of a SciPy window.

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
    if estimator == "H2" and len(input_channels) > 1:
        raise ValueError("estimator H2 is not allowed with several inputs; use H1")
    for channel in (*input_channels, *output_channels):
        if not np.isfinite(record.signals[channel]).all():
            raise ValueError(f"channel {channel.name} contains numbers that are not finite")
        check_sizes(record.signals[channel], f"channel {channel.name}")
    n = _samples(record, segment)
    rows = np.stack([record.signals[c] for c in (*input_channels, *output_channels)])
    rows = rows.reshape(len(rows), record.repeats, -1)
    frequencies, S = _spectra(rows, record.sample_time, n, window)
    values, coherence = responses(S, len(input_channels), estimator)
    return tuple(
        FrequencyResponse(output, source, frequencies, values[:, k, j], coherence[:, k], 1.0 / (n * record.sample_time))
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


def _spectra(rows: Array, sample_time: float, n: int, window: str) -> tuple[Array, Complex]:
    """Return the frequencies (Hz) above 0 and the spectra, shape (frequencies, channels, channels).

    Rows have the shape (channels, repeats, samples); no segment extends over two repeats.
    """
    try:
        weights = get_window(window, n)
    except ValueError as error:
        raise ValueError(f"window {window!r} is not allowed: {error}") from error
    overlap = 0 if window == "boxcar" else n // 2
    # scipy's csd(x, y) averages X^* Y
    frequencies, S = csd(rows[None], rows[:, None], 1.0 / sample_time, weights, n, overlap, detrend="constant")
    inner = slice(1, -1 if n % 2 == 0 else None)
    return frequencies[inner], np.moveaxis(S.mean(axis=2), -1, 0)[inner]
