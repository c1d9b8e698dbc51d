"""Natural frequencies, damping ratios and shapes from frequency responses, mode by mode.

Near a resonance all responses share a pole lambda, and other modes add little that is not smooth:

    H_c(j omega) = N_c(j omega)/(j omega - lambda),   N_c = b_0c + b_1c s + b_2c s^2,  complex        (1)

Multiplied by the denominator this is linear in lambda and N_c. It is solved by least squares, weighted by the
denominator of the last iteration (C. K. Sanathanan, J. Koerner, IEEE Trans. Autom. Control 8 (1963) 56-58). The shape
is the residue N_c(lambda) of each response.

An estimate from records is an average over the width 1/T of its lines, T the length of a segment. A peak whose fitted
half-power width is

    2 zeta f < 4.5/T                                                                                  (2)

has a damping ratio that is too large by 10 % or more with the window `hann`; by 88 % if its true width is that of a
line. Its damping is unknown. So is that of a peak narrower than the spacing of measured lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import find_peaks

from amb_analysis.measured.records import FrequencyResponse
from array_types import Array, Complex, Indices

PROMINENCE = 0.6  # decades of power by which a peak rises above its surroundings: 6 dB
ITERATIONS = 30
LEAST_LINES = 7  # frequencies of a fit
WIDTHS = 4.0  # half-power widths on each side of the peak
RESOLVED = 4.5  # of (2)
CLEAR = 30.0  # power of a peak over the median, which noise does not reach in 1e8 lines
WELL = 0.2  # relative error of a fit, below which a peak is one of a pole
SPIKE = 0.5  # lines of width, below which it may be one of a disturbance, such as the mains
AROUND = 5  # lines on each side of a peak, whose coherence is averaged: that of a narrow peak is low at its top
LEAST_COHERENCE = 0.5  # about a peak, below which it is noise: mean of the responses


@dataclass(frozen=True, eq=False)
class FittedMode:
    """A mode of some responses.

    frequency
        |Im lambda|/2 pi (Hz).
    damping_ratio
        -Re lambda/|lambda| (1).
    shape
        Residue of each response, in their order, shape (responses,).
    lines
        Half-power width of the peak by the spacing of lines (1).
    error
        Root mean square of the difference of the fit from the responses, over that of the responses (1).
    height
        Mean power of the responses at the peak over their medians (1).
    is_resolved
        Whether the damping ratio is one of the vibration, not of the lines (2).
    """

    frequency: float
    damping_ratio: float
    shape: Complex
    lines: float = np.inf
    error: float = 0.0
    height: float = 1.0
    is_resolved: bool = True


def fitted_modes(responses: Sequence[FrequencyResponse]) -> tuple[FittedMode, ...]:
    """Return the modes at the peaks of some responses by (1), by ascending frequency; peaks of low coherence have none.

    Parameters
    ----------
    responses
        With the same frequencies.

    Raises
    ------
    ValueError
        If they have different frequencies.
    """
    frequencies, H, power, peaks = _peaks(responses)
    least = RESOLVED if any(item.resolution is not None for item in responses) else 1.0
    result = []
    for k, peak in enumerate(peaks):
        lines = _near(power, frequencies, peaks, k)
        mode = _fit(frequencies[lines], H[:, lines])
        if mode is not None:
            width = 2.0 * mode.damping_ratio * mode.frequency / float(np.gradient(frequencies)[peak])
            result.append(replace(mode, lines=width, is_resolved=width >= least, height=float(power[peak])))
    return tuple(result)


def peak_frequencies(responses: Sequence[FrequencyResponse]) -> Array:
    """Return the frequencies of the peaks of some responses (Hz), with a mode or without; see `fitted_modes`."""
    frequencies, _, _, peaks = _peaks(responses)
    return frequencies[peaks]


def is_conjugate(responses: Sequence[FrequencyResponse]) -> bool:
    """Return whether the poles at the peaks of some responses grow: they are written with exp(-j omega t).

    Growing poles then fit more peaks than decaying ones. Only peaks that are high and fitted well count, because the
    pole of noise may do either.
    """
    turned = [replace(item, values=item.values.conj()) for item in responses]
    return _clear_poles(turned) > _clear_poles(responses)


def _clear_poles(responses: Sequence[FrequencyResponse]) -> int:
    return sum(mode.error < WELL and mode.lines > SPIKE and mode.height > CLEAR for mode in fitted_modes(responses))


def _peaks(responses: Sequence[FrequencyResponse]) -> tuple[Array, Complex, Array, Indices]:
    """Return the frequencies, the responses, shape (responses, n), their mean power and the numbers of its peaks."""
    frequencies = responses[0].frequencies
    if any(not np.array_equal(item.frequencies, frequencies) for item in responses):
        raise ValueError("responses with different frequencies are not allowed; modes need common ones")
    H = np.stack([item.values for item in responses])
    power = np.mean(np.abs(H) ** 2 / np.median(np.abs(H) ** 2, axis=1, keepdims=True), axis=0)
    peaks, _ = find_peaks(np.log10(np.maximum(power, np.finfo(float).tiny)), prominence=PROMINENCE)
    known = [item.coherence for item in responses if item.coherence is not None]
    if known:
        mean = np.mean(known, axis=0)
        peaks = peaks[[mean[max(0, k - AROUND) : k + AROUND + 1].mean() >= LEAST_COHERENCE for k in peaks]]
    return frequencies, H, power, peaks


def _near(power: Array, frequencies: Array, peaks: Indices, k: int) -> slice:
    """Return the lines within some half-power widths of a peak, and between its neighbours."""
    peak = int(peaks[k])
    first = 0 if k == 0 else (peaks[k - 1] + peak + 1) // 2
    last = len(frequencies) if k == len(peaks) - 1 else (peaks[k + 1] + peak + 1) // 2
    below, above = peak, peak
    while below > first and power[below] > 0.5 * power[peak]:
        below -= 1
    while above < last - 1 and power[above] > 0.5 * power[peak]:
        above += 1
    width = WIDTHS * 0.5 * (frequencies[above] - frequencies[below])
    ends = np.searchsorted(frequencies, [frequencies[peak] - width, frequencies[peak] + width])
    reach = LEAST_LINES // 2
    return slice(max(first, min(int(ends[0]), peak - reach)), min(last, max(int(ends[1]) + 1, peak + reach + 1)))


def _fit(frequencies: Array, H: Complex) -> FittedMode | None:
    """Return the mode by (1) from H, shape (responses, lines); None if the pole does not decay or lies outside."""
    n = len(frequencies)
    if n < 5:
        return None
    middle, half = 0.5 * (frequencies[0] + frequencies[-1]), 0.5 * (frequencies[-1] - frequencies[0])
    s = 1j * (frequencies - middle) / half
    sizes = np.linalg.norm(H, axis=1)
    H = H / sizes[:, None]
    basis = np.stack([np.ones(n), s, s**2], axis=1)
    weight = np.ones(n)
    pole = 0.0j
    for _ in range(ITERATIONS):
        # N_c + pole H_c = s H_c, with each N_c eliminated by projection
        Q = np.linalg.qr(basis * weight[:, None])[0]
        left, right = weight * H, weight * s * H
        left, right = (v - (v @ Q.conj()) @ Q.T for v in (left, right))
        new = np.vdot(left, right) / np.vdot(left, left).real
        weight = 1.0 / np.maximum(np.abs(s - new), 1e-9)
        if abs(new - pole) < 1e-12:
            break
        pole = new
    value = 2.0 * np.pi * (half * new + 1j * middle)
    inside = frequencies[0] <= value.imag / (2.0 * np.pi) <= frequencies[-1]
    if not inside or not value.real < 0.0:
        return None
    numerators = np.linalg.lstsq(basis * weight[:, None], (weight * (s - new) * H).T, rcond=None)[0]
    rest = weight * ((s - new) * H - (basis @ numerators).T)
    return FittedMode(
        float(value.imag / (2.0 * np.pi)),
        float(-value.real / abs(value)),
        np.asarray(sizes * (np.array([1.0, new, new**2]) @ numerators)),
        error=float(np.linalg.norm(rest) / np.linalg.norm(weight * np.abs(s - new) * np.abs(H))),
    )
