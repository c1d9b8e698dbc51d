"""Deviation of computed responses and modes from measured ones.

    FRAC = |sum H_m^* H_c|^2 / (sum |H_m|^2 sum |H_c|^2)      over frequency                         (1)
    MAC  = |phi_m^H phi_c|^2 / (phi_m^H phi_m phi_c^H phi_c)  over responses                         (2)

A value of 1 means that the measured and the computed values are equal up to a complex factor. The sums in (1) contain
mostly the largest values, which for the displacement of a free rotor are the first lines, 1/(m omega^2). (1) is
therefore computed for the acceleration, whatever the unit of the motion, and in each octave. The FRAC of a response is
the mean over its octaves, weighted by their numbers of lines. R. J. Allemang, The modal
assurance criterion: twenty years of use and abuse, Sound and Vibration 37 (2003) 14-21.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from scipy.optimize import linear_sum_assignment

from amb_analysis.measured.modal_fit import FittedMode
from amb_analysis.measured.records import FrequencyResponse
from array_types import Array, Complex

ORDERS = {"m": 0, "m/s": 1, "m/s2": 2}  # derivatives of the displacement
OCTAVE, LEAST_LINES = 2.0, 8  # ratio of the ends of a band, and its fewest lines
FARTHEST = 0.2  # relative difference of frequency above which two modes are not paired


@dataclass(frozen=True)
class CurveDeviation:
    """Deviation of a computed response from a measured one.

    frac
        FRAC by (1), mean over octaves.
    least, band
        FRAC of the octave in which it is least, and the ends of that octave (Hz).
    decibel
        Root mean square of 20 log10 |H_c/H_m| (dB).
    """

    frac: float
    least: float
    band: Annotated[tuple[float, float], "Hz"]
    decibel: Annotated[float, "dB"]


@dataclass(frozen=True)
class ModeDeviation:
    """A measured mode and the computed mode paired with it, or one of them alone.

    measured, computed
        Frequencies (Hz); one of them is None if no mode within 20 % matches the other.
    percent
        Relative deviation of the computed from the measured frequency (%).
    measured_damping, computed_damping
        Damping ratios (1); None if they are not available or not resolved.
    mac
        MAC by (2); None if there is only one response.
    """

    measured: Annotated[float | None, "Hz"]
    computed: Annotated[float | None, "Hz"]
    percent: Annotated[float | None, "%"]
    measured_damping: float | None
    computed_damping: float | None
    mac: float | None


def curve_deviation(measured: FrequencyResponse, computed: Complex) -> CurveDeviation:
    """Return the deviation of computed values, shape (n,), from a measured response."""
    f = measured.frequencies
    scale = f ** (2.0 - ORDERS.get(measured.output.unit, 2))
    bands = octaves(f)
    fracs = np.array([assurance((scale * measured.values)[band], (scale * computed)[band]) for band in bands])
    worst, sizes = int(np.argmin(fracs)), np.array([band.stop - band.start for band in bands])
    ends = float(f[bands[worst]][0]), float(f[bands[worst]][-1])
    levels = np.log10(np.maximum(np.abs(computed), 1e-300) / np.maximum(np.abs(measured.values), 1e-300))
    mean = float(fracs @ sizes / sizes.sum())
    return CurveDeviation(mean, float(fracs[worst]), ends, float(20.0 * np.sqrt(np.mean(levels**2))))


def octaves(frequencies: Array) -> list[slice]:
    """Return the octaves of ascending frequencies, shape (n,), each with at least `LEAST_LINES` lines if there are."""
    result, first, n = [], 0, len(frequencies)
    while first < n:
        last = max(int(np.searchsorted(frequencies, OCTAVE * frequencies[first])), first + LEAST_LINES)
        last = n if n - last < LEAST_LINES else last
        result.append(slice(first, last))
        first = last
    return result


def assurance(a: Complex, b: Complex) -> float:
    """Return the squared correlation of two complex vectors, as in (1) and (2); 0 if one of them is zero."""
    sizes = np.vdot(a, a).real * np.vdot(b, b).real
    return float(np.abs(np.vdot(a, b)) ** 2 / sizes) if sizes > 0.0 else 0.0


def mode_deviations(measured: Sequence[FittedMode], computed: Sequence[FittedMode]) -> tuple[ModeDeviation, ...]:
    """Return each measured mode with the computed mode nearest in frequency and shape, and computed modes without one.

    No computed mode is used twice. Shapes are compared if both modes have at least two responses.
    """
    cost = np.full((len(measured), len(computed) + len(measured)), 2.0 * FARTHEST + 1.0)
    for i, m in enumerate(measured):
        for j, c in enumerate(computed):
            off = abs(c.frequency / m.frequency - 1.0)
            if off <= FARTHEST:
                cost[i, j] = off + FARTHEST * (1.0 - (_mac(m, c) or 0.0))
    rows, columns = linear_sum_assignment(cost)
    pairs = {i: j for i, j in zip(rows, columns, strict=True) if j < len(computed) and cost[i, j] <= 2.0 * FARTHEST}
    matched = [_pair(m, computed[pairs[i]] if i in pairs else None) for i, m in enumerate(measured)]
    lone = [c for j, c in enumerate(computed) if j not in pairs.values()]
    return (*matched, *(ModeDeviation(None, c.frequency, None, None, c.damping_ratio, None) for c in lone))


def _mac(m: FittedMode, c: FittedMode) -> float | None:
    return assurance(m.shape, c.shape) if len(m.shape) > 1 and len(c.shape) == len(m.shape) else None


def _pair(m: FittedMode, c: FittedMode | None) -> ModeDeviation:
    ratio = m.damping_ratio if m.is_resolved and not np.isnan(m.damping_ratio) else None
    if c is None:
        return ModeDeviation(m.frequency, None, None, ratio, None, None)
    percent = 100.0 * (c.frequency / m.frequency - 1.0)
    return ModeDeviation(m.frequency, c.frequency, percent, ratio, c.damping_ratio, _mac(m, c))
