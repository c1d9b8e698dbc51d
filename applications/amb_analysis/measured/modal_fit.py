"""Natural frequencies, damping ratios and shapes from frequency responses, mode by mode.

Near a resonance, all responses share a pole lambda, and the contributions of other modes are nearly smooth:

    H_c(j omega) = N_c(j omega)/(j omega - lambda),   N_c = b_0c + b_1c s + b_2c s^2,  complex        (1)

When (1) is multiplied by the denominator, it is linear in lambda and N_c. It is solved by least squares, with weights
from the denominator of the previous iteration (C. K. Sanathanan, J. Koerner, IEEE Trans. Autom. Control 8 (1963)
56-58). The mode shape consists of the residues N_c(lambda) of the responses.

An estimate from segments with a window such as `hann` is an average over the width 1/T of its lines, where T is the
length of a segment. A peak whose fitted half-power width is

    2 zeta f < 4.5/T                                                                                  (2)

has a damping ratio that is too large by 10 % or more with the window `hann`, and by 88 % if its true width is one line.
The damping of such a peak is therefore considered unknown, as is the damping of a peak narrower than the spacing of
measured lines. The lines of a blow have the poles of the rotor (`blows`), so that (2) does not apply to them, and half
the spacing suffices.

An exponential window exp(-t/tau) of the records adds 1/tau to the decay of each vibration, which is subtracted:

    lambda = lambda_fitted + 1/tau                                                                    (3)

If less than a tenth of 1/tau remains, the damping is considered unknown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import find_peaks
from scipy.stats import gamma

from amb_analysis.measured.records import FrequencyResponse
from array_types import Array, Complex, Indices

PROMINENCE = 0.6  # decades of power by which a peak rises above its surroundings: 6 dB
ITERATIONS = 30
LEAST_LINES = 7  # frequencies of a fit
HEAVY = (0.05, 0.5)  # damping ratios of a mode without a peak of 6 dB; beyond, 1 % of noise shifts it by 15 %
PEAK = 6.0  # half widths, or lines, on each side of a light mode that are left out of its fit
NONE: Complex = np.zeros(0, np.complex128)
SMOOTH = 0.1  # relative error of a polynomial, below which a curve has no mode
LEAST_HEAVY, MOST_HEAVY = 30, 2000  # lines of its fit
BETTER = 6.0  # ratio of the squares of rests, above which a peak is one of two modes
LEAST_FREEDOM = 6  # of the rests of two modes
LEAST_PART = 0.1  # of the smaller of two modes in their peak
LEAST_APART = 0.5  # of the sum of half widths of two modes
WIDTHS = 4.0  # half-power widths on each side of the peak
RESOLVED, SHARP = 4.5, 0.5  # lines of (2), and of the responses to blows
OF_WINDOW = 0.1  # decay of a vibration over that of the window, below which (3) leaves mostly errors
CLEAR = 30.0  # power of a peak over the median, which noise does not reach in 1e8 lines
WELL = 0.2  # relative error of a fit, below which a peak is one of a pole
EXACTLY = 0.1  # relative error of a fit, above which a peak narrower than a line may be noise
SURROUNDINGS, OWN_LINES, LEAST_SURROUNDINGS = 40, 3, 10  # lines on each side of a peak; its own; fewest for the noise
BY_CHANCE = 1e-8  # probability that noise has such a peak
SPIKE = 0.5  # lines of width, below which it may be one of a disturbance, such as the mains
AROUND = 5  # lines on each side of a peak, whose coherence is averaged: that of a narrow peak is low at its top
LEAST_COHERENCE = 0.5  # about a peak, below which it is noise: mean of the responses
CERTAIN = 0.9  # coherence about a peak, below which it is noise if narrower than a line or not fitted `WELL`


@dataclass(frozen=True, eq=False)
class FittedMode:
    """A mode fitted to several responses.

    frequency
        |Im lambda|/2 pi (Hz).
    damping_ratio
        -Re lambda/|lambda| (1), without the damping of an exponential window (3).
    shape
        Residue of each response, in the order of the responses, shape (responses,).
    lines
        Ratio of the half-power width of the peak to the spacing of the lines (1).
    error
        Root-mean-square deviation of the fit from the responses, relative to the root mean square of the responses (1).
    height
        Ratio of a response's power at the peak to its median power, averaged over the responses (1).
    is_resolved
        Whether, by (2) and (3), the damping ratio describes the vibration rather than the window or the lines.
    """

    frequency: float
    damping_ratio: float
    shape: Complex
    lines: float = np.inf
    error: float = 0.0
    height: float = 1.0
    is_resolved: bool = True


def fitted_modes(responses: Sequence[FrequencyResponse]) -> tuple[FittedMode, ...]:
    """Return the modes at the peaks of some responses by (1), in order of frequency.

    Noise also has peaks, so a peak with low coherence is not taken for a mode. A peak with uncertain coherence is not
    taken for a mode if no pole fits it, or if it is narrower than a line. A peak narrower than a line is a mode only if
    a pole fits it closely, even if no coherence was measured.

    Parameters
    ----------
    responses
        Responses at the same frequencies, from records with the same exponential window or none.

    Raises
    ------
    ValueError
        If the responses have different frequencies or windows.
    """
    frequencies, H, power, peaks = _peaks(responses)
    coherences = _coherences(responses, peaks)
    least = RESOLVED if any(item.resolution is not None for item in responses) else 1.0
    enough = SHARP if all(item.estimate is not None and item.estimate.blows for item in responses) else least
    result = []
    for k, peak in enumerate(peaks):
        spacing = float(np.gradient(frequencies)[peak])
        regions = [_near(power, frequencies, peaks, k, reach) for reach in (WIDTHS, 2.0 * WIDTHS)]
        found = [_fits(frequencies[lines], H[:, lines], least * spacing) for lines in regions]
        for mode in next((pair for pair in found if len(pair) == 2), found[0]):
            width = 2.0 * mode.damping_ratio * mode.frequency / spacing
            if coherences[k] < CERTAIN and (mode.error > WELL or width < 1.0):
                continue
            if width < 1.0 and mode.error > EXACTLY:
                continue
            if not _is_within(frequencies, mode) or not _stands_out(responses, H, regions[0], int(peak), mode):
                continue
            result.append(replace(mode, lines=width, is_resolved=width >= enough, height=float(power[peak])))
    heavy = _heavily_damped(responses, frequencies, H, result)
    modes = (_without_window(mode, responses[0].decay) for mode in (*result, *heavy))
    return tuple(sorted(modes, key=lambda mode: mode.frequency))


def _without_window(mode: FittedMode, added: float) -> FittedMode:
    """Return a mode without the decay (1/s) that an exponential window has added to it, by (3)."""
    if not added:
        return mode
    rate = -2.0 * np.pi * _pole(mode).real - added
    ratio = float(rate / np.hypot(rate, 2.0 * np.pi * mode.frequency))
    proper = replace(mode, damping_ratio=ratio)
    return replace(proper, is_resolved=mode.is_resolved and not is_masked(proper, added))


def is_masked(mode: FittedMode, added: float) -> bool:
    """Return whether an exponential window adds so much decay (1/s) that the damping of a mode is unknown."""
    return bool(-2.0 * np.pi * _pole(mode).real < OF_WINDOW * added)


def doubtful_modes(responses: Sequence[FrequencyResponse]) -> tuple[tuple[float, float], ...]:
    """Return frequency (Hz) and mean coherence of the modes that are not listed only because of their coherence.

    Parameters
    ----------
    responses
        As for `fitted_modes`.
    """
    if all(item.coherence is None for item in responses):
        return ()
    found = [mode.frequency for mode in fitted_modes(responses)]
    f = responses[0].frequencies
    others = [
        int(np.argmin(np.abs(f - mode.frequency)))
        for mode in fitted_modes([replace(item, coherence=None) for item in responses])
        if not any(abs(mode.frequency - other) <= mode.damping_ratio * other for other in found)
    ]
    means = _coherences(responses, np.array(others, np.intp))
    return tuple((float(f[k]), float(mean)) for k, mean in zip(others, means, strict=True) if mean < CERTAIN)


def _heavily_damped(
    responses: Sequence[FrequencyResponse], frequencies: Array, H: Complex, light: Sequence[FittedMode]
) -> tuple[FittedMode, ...]:
    """Return a heavily damped mode, which has no peak of 6 dB, if one such mode fits all responses.

    Both of its poles, lambda and its conjugate, affect all lines, so (1) with two poles is exact. Each lightly damped
    mode adds a term with its pole to the fit, and the lines of its peak are left out. If polynomials of degree 3 and
    the lightly damped modes fit the curves, there is no heavily damped mode.
    """
    known = [float(item.coherence.mean()) for item in responses if item.coherence is not None]
    off = np.ones(len(frequencies), np.bool_)
    for mode in light:
        reach = PEAK * max(mode.damping_ratio * mode.frequency, float(np.diff(frequencies).max()))
        off &= np.abs(frequencies - mode.frequency) > reach
    thin = slice(None, None, 1 + int(off.sum()) // MOST_HEAVY)
    frequencies, H = frequencies[off][thin], H[:, off][:, thin]
    if len(frequencies) < LEAST_HEAVY or (known and np.mean(known) < LEAST_COHERENCE):
        return ()
    poles = np.array([_pole(mode) for mode in light], np.complex128)
    polynomial = _error(frequencies, H, poles)
    modes = [
        mode
        for mode in _fit(frequencies, H, 2, poles)
        if HEAVY[0] <= mode.damping_ratio <= HEAVY[1] and _lines_within(frequencies, mode) >= LEAST_LINES
    ]
    if len(modes) != 1 or polynomial < SMOOTH or modes[0].error > min(WELL, polynomial / float(np.sqrt(BETTER))):
        return ()
    width = 2.0 * modes[0].damping_ratio * modes[0].frequency
    return (replace(modes[0], lines=width / float(np.diff(frequencies).max())),)


def _is_within(frequencies: Array, mode: FittedMode) -> bool:
    """Return whether the lines contain the half-power width of a mode, so that it is not at their edge."""
    half = mode.damping_ratio * mode.frequency
    return bool(frequencies[0] <= mode.frequency - half and mode.frequency + half <= frequencies[-1])


def _lines_within(frequencies: Array, mode: FittedMode) -> int:
    """Return the number of lines within the half-power width of a mode; 0 if the mode is at the edge of the lines."""
    if not _is_within(frequencies, mode):
        return 0
    return int(np.sum(np.abs(frequencies - mode.frequency) <= mode.damping_ratio * mode.frequency))


def _stands_out(responses: Sequence[FrequencyResponse], H: Complex, region: slice, peak: int, mode: FittedMode) -> bool:
    """Return whether the noise around a peak is too small to cause it.

    The second differences d of neighbouring lines contain mostly noise; if its variance is sigma^2, the median of |d|^2
    is 6 sigma^2 ln(2). Let r_c be the residue of a response. If it was noise, sum |r_c/(s - lambda)|^2/sigma_c^2 over
    the lines of the peak and the responses would have a gamma distribution. An exponential window makes neighbouring
    lines alike, so that the lines of the differences are further apart.
    """
    frequencies = responses[0].frequencies
    spacing = float(np.gradient(frequencies)[peak])
    lag = 1 + int(np.ceil(responses[0].decay / (np.pi * spacing)))
    reach = np.arange(max(peak - lag * SURROUNDINGS, lag), min(peak + lag * SURROUNDINGS, len(frequencies) - lag))
    reach = reach[np.abs(reach - peak) > lag * OWN_LINES]
    if len(reach) < LEAST_SURROUNDINGS:
        return True
    squares = np.abs(H[:, reach - lag] - 2.0 * H[:, reach] + H[:, reach + lag]) ** 2
    variances = np.median(squares, axis=1) / (6.0 * np.log(2.0))
    distances = np.abs(1j * frequencies[region] - _pole(mode)) * 2.0 * np.pi
    parts = np.abs(mode.shape) ** 2 * float(np.sum(distances**-2.0))
    ratio = float(np.sum(parts / np.maximum(variances, np.finfo(float).tiny)))
    return ratio > float(gamma.isf(BY_CHANCE, len(H)))


def _pole(mode: FittedMode) -> complex:
    """Return lambda/(2 pi) of a mode (Hz)."""
    return mode.frequency * complex(-mode.damping_ratio / np.sqrt(1.0 - mode.damping_ratio**2), 1.0)


def _error(frequencies: Array, H: Complex, poles: Complex) -> float:
    """Return the relative error of a fit by polynomials of degree 3 and a residue at each of the poles (Hz)."""
    _, basis = _basis(frequencies, 4, poles)
    scaled = (H / np.linalg.norm(H, axis=1)[:, None]).T
    rest = scaled - basis @ np.linalg.lstsq(basis, scaled, rcond=None)[0]
    return float(np.linalg.norm(rest)) / float(np.sqrt(len(H)))


def _basis(frequencies: Array, count: int, poles: Complex) -> tuple[Complex, Complex]:
    """Return s of (1), scaled to range from -j to j, and a matrix of basis functions.

    Its columns are s^k for k < `count`, and 1/(s - pole) for each of the poles (Hz).
    """
    middle, half = 0.5 * (frequencies[0] + frequencies[-1]), 0.5 * (frequencies[-1] - frequencies[0])
    s = 1j * (frequencies - middle) / half
    columns = [s**k for k in range(count)] + [1.0 / (s - (pole - 1j * middle) / half) for pole in poles]
    return s, np.stack(columns, axis=1)


def peak_frequencies(responses: Sequence[FrequencyResponse]) -> Array:
    """Return the frequencies (Hz) of all peaks of responses, whether or not a mode fits them; see `fitted_modes`."""
    frequencies, _, _, peaks = _peaks(responses)
    return frequencies[peaks]


def is_conjugate(responses: Sequence[FrequencyResponse]) -> bool:
    """Return whether the poles at the peaks of the responses grow, which indicates the convention exp(-j omega t).

    In this convention, growing poles fit more peaks than decaying poles do. Only high peaks that are fitted well are
    counted, because poles fitted to noise may either grow or decay.
    """
    turned = [replace(item, values=item.values.conj()) for item in responses]
    return _clear_poles(turned) > _clear_poles(responses)


def _clear_poles(responses: Sequence[FrequencyResponse]) -> int:
    return sum(mode.error < WELL and mode.lines > SPIKE and mode.height > CLEAR for mode in fitted_modes(responses))


def _peaks(responses: Sequence[FrequencyResponse]) -> tuple[Array, Complex, Array, Indices]:
    """Return frequencies, responses of shape (responses, n), their mean power, and the indices of the power's peaks."""
    frequencies = responses[0].frequencies
    if any(not np.array_equal(item.frequencies, frequencies) for item in responses):
        raise ValueError(
            "responses with different frequencies are not allowed; fitting modes requires common frequencies"
        )
    if len({item.decay for item in responses}) > 1:
        raise ValueError("responses with different exponential windows are not allowed; fit the modes of each window")
    H = np.stack([item.values for item in responses])
    power = np.mean(np.abs(H) ** 2 / np.median(np.abs(H) ** 2, axis=1, keepdims=True), axis=0)
    peaks, _ = find_peaks(np.log10(np.maximum(power, np.finfo(float).tiny)), prominence=PROMINENCE)
    peaks = peaks[_coherences(responses, peaks) >= LEAST_COHERENCE]
    return frequencies, H, power, peaks


def _coherences(responses: Sequence[FrequencyResponse], peaks: Indices) -> Array:
    """Return the mean coherence around each peak; 1 if no coherence was measured."""
    known = [item.coherence for item in responses if item.coherence is not None]
    if not known:
        return np.ones(len(peaks))
    mean = np.mean(known, axis=0)
    return np.array([mean[max(0, k - AROUND) : k + AROUND + 1].mean() for k in peaks])


def _near(power: Array, frequencies: Array, peaks: Indices, k: int, reach: float) -> slice:
    """Return the lines within `reach` half-power widths of a peak, but at most half-way to the neighbouring peaks."""
    peak = int(peaks[k])
    first = 0 if k == 0 else (peaks[k - 1] + peak + 1) // 2
    last = len(frequencies) if k == len(peaks) - 1 else (peaks[k + 1] + peak + 1) // 2
    below, above = peak, peak
    while below > first and power[below] > 0.5 * power[peak]:
        below -= 1
    while above < last - 1 and power[above] > 0.5 * power[peak]:
        above += 1
    width = reach * 0.5 * (frequencies[above] - frequencies[below])
    ends = np.searchsorted(frequencies, [frequencies[peak] - width, frequencies[peak] + width])
    least = LEAST_LINES // 2
    return slice(max(first, min(int(ends[0]), peak - least)), min(last, max(int(ends[1]) + 1, peak + least + 1)))


def _fits(frequencies: Array, H: Complex, narrowest: float) -> list[FittedMode]:
    """Return the modes near a peak from H, shape (responses, lines): one, two if they fit much better, or none.

    With p poles, (1) has the denominator prod(s - lambda_j) and polynomials N_c of degree p + 1. With the residuals e
    and their degrees of freedom d, two poles are better if (e_1^2/d_1)/(e_2^2/d_2) > 6. Both poles must decay, lie
    within the frequency range of the lines, and contribute to the peak. Their half-power widths must be at least
    `narrowest` (Hz), the width that the lines resolve. This condition is needed because two poles fit the spectral
    shape of an estimate's window better than one pole does.
    """
    one, two = (_fit(frequencies, H, p) for p in (1, 2))
    count, n = H.shape
    freedom_1, freedom_2 = count * (n - 3) - 1, count * (n - 4) - 2
    if len(two) == 2 and freedom_2 >= LEAST_FREEDOM:
        before = min((mode.error for mode in one), default=1.0) ** 2 / freedom_1
        sizes = [float(np.linalg.norm(m.shape)) / (m.damping_ratio * m.frequency) for m in two]
        apart = abs(two[0].frequency - two[1].frequency)
        widths = sum(mode.damping_ratio * mode.frequency for mode in two)
        is_pair = min(2.0 * m.damping_ratio * m.frequency for m in two) >= narrowest
        is_pair &= min(sizes) > LEAST_PART * max(sizes) and apart > LEAST_APART * widths
        if is_pair and before > BETTER * two[0].error ** 2 / freedom_2:
            return two
    return one


def _fit(frequencies: Array, H: Complex, order: int, light: Complex = NONE) -> list[FittedMode]:
    """Return the modes by (1) with `order` poles, except poles that do not decay or are outside the lines' range.

    Each of the known poles `light` (Hz) adds a term with this pole to N_c.
    """
    n = H.shape[1]
    if n < 4 + order + len(light):
        return []
    middle, half = 0.5 * (frequencies[0] + frequencies[-1]), 0.5 * (frequencies[-1] - frequencies[0])
    sizes = np.linalg.norm(H, axis=1)
    H = H / sizes[:, None]
    s, basis = _basis(frequencies, order + 2, light)
    powers = [s**k * H for k in range(order + 1)]
    weight = np.ones(n)
    poles: Complex = np.zeros(order, np.complex128)
    for _ in range(ITERATIONS):
        # N_c - (a_0 + ... a_p-1 s^(p-1)) H_c = s^p H_c, with each N_c eliminated by projection
        Q = np.linalg.qr(basis * weight[:, None])[0]
        left = [(v - (v @ Q.conj()) @ Q.T).ravel() for v in (weight * power for power in powers)]
        factors = np.linalg.lstsq(np.stack(left[:-1], axis=1), -left[-1], rcond=None)[0]
        new = np.asarray(np.roots([1.0, *factors[::-1]]), np.complex128)
        weight = 1.0 / np.maximum(np.abs(np.prod(s[:, None] - new, axis=1)), 1e-9)
        if len(new) == len(poles) and np.abs(np.sort_complex(new) - np.sort_complex(poles)).max() < 1e-12:
            break
        poles = new
    denominator = np.prod(s[:, None] - new, axis=1)
    numerators = np.linalg.lstsq(basis * weight[:, None], (weight * denominator * H).T, rcond=None)[0]
    rest = weight * (denominator * H - (basis @ numerators).T)
    error = float(np.linalg.norm(rest) / np.linalg.norm(weight * np.abs(denominator) * np.abs(H)))
    modes = []
    for j in np.argsort(new.imag):
        value = 2.0 * np.pi * (half * new[j] + 1j * middle)
        if frequencies[0] <= value.imag / (2.0 * np.pi) <= frequencies[-1] and value.real < 0.0:
            others = np.prod(new[j] - np.delete(new, j))
            at_pole = [*new[j] ** np.arange(order + 2), *(1.0 / (new[j] - (light - 1j * middle) / half))]
            shape = sizes * (np.array(at_pole) @ numerators) / others * half
            hertz, ratio = float(value.imag / (2.0 * np.pi)), float(-value.real / abs(value))
            modes.append(FittedMode(hertz, ratio, np.asarray(shape), error=error))
    return modes
