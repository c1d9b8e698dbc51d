"""Peaks of a response as a function of spin speed, their amplification and distance from the operating speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from array_types import Array
from rotor_analysis.refinement import vertex

UNDAMPED = 1e6  # amplification from which rounding is all that limits a peak


@dataclass(frozen=True)
class Peak:
    """A critical speed of a response.

    Omega, amplitude
        Speed (rad/s) and amplitude at the peak.
    amplification
        AF = Omega/(Omega_2 - Omega_1), where Omega_1 and Omega_2 are the speeds at which the amplitude is 1/sqrt(2) of
        the peak.
    from_single_side
        Whether only one of these speeds exists; the width is then twice the distance of this speed from the peak.
    """

    Omega: float
    amplitude: float
    amplification: float
    from_single_side: bool = False


def peaks_of(speeds: Array, amplitudes: Array) -> list[Peak]:
    """Return the peaks of a response, each with its amplification according to the half-power width.

    A maximum is a peak only if, on at least one side, the amplitude falls to 1/sqrt(2) of the maximum before rising
    above the maximum. Between samples, the inverse square of the amplitude is interpolated, because this inverse is a
    parabola near a resonance.

    Parameters
    ----------
    speeds
        Ascending speeds (rad/s), shape (n,), closely spaced about each peak (`refined_response`).
    amplitudes
        Amplitudes at these speeds, shape (n,).
    """
    result = []
    for k in np.flatnonzero((amplitudes[1:-1] >= amplitudes[:-2]) & (amplitudes[1:-1] > amplitudes[2:])) + 1:
        with np.errstate(divide="ignore"):
            compliance = (amplitudes[k] / amplitudes) ** 2
        Omega, lowest = (float(value) for value in vertex(speeds[k - 1 : k + 2], compliance[k - 1 : k + 2])[:2])
        if not 0.9 < lowest <= 1.0:  # samples that do not resolve the peak
            Omega, lowest = float(speeds[k]), 1.0
        before = _crossing(speeds[k::-1], compliance[k::-1], 2.0 * lowest, lowest)
        after = _crossing(speeds[k:], compliance[k:], 2.0 * lowest, lowest)
        if before is not None or after is not None:
            result.append(_peak(Omega, float(amplitudes[k] / np.sqrt(lowest)), before, after))
    return result


def highest_peaks(speeds: Array, curves: Mapping[str, Array]) -> list[tuple[str, Peak]]:
    """Return the peaks of the amplitudes at several locations, by speed, each with the location where it is highest.

    Peaks at two locations count as the same critical speed if their speeds differ by at most half of the half-power
    width.
    """
    peaks = [(name, peak) for name, amplitudes in curves.items() for peak in peaks_of(speeds, amplitudes)]
    groups: list[list[tuple[str, Peak]]] = []
    for name, peak in sorted(peaks, key=lambda named: named[1].Omega):
        width = peak.Omega * max(0.5 / peak.amplification, 1.0 / UNDAMPED)
        if groups and peak.Omega - groups[-1][-1][1].Omega <= width:
            groups[-1].append((name, peak))
        else:
            groups.append([(name, peak)])
    return [max(group, key=lambda named: named[1].amplitude) for group in groups]


def _crossing(speeds: Array, values: Array, level: float, lowest: float) -> float | None:
    """Return the first speed at which `values` reach `level`; None if they never do or fall below `lowest` before."""
    beyond = np.flatnonzero(values >= level)
    if not len(beyond) or values[: beyond[0]].min() < lowest * (1.0 - 1e-6):
        return None
    n = int(beyond[0])
    near = [k for k in range(n - 2, n + 2) if 0 <= k < len(values) and np.isfinite(values[k])]
    if n not in near:
        return float(speeds[n])
    through = BarycentricInterpolator(speeds[near], values[near] - level)
    low, high = sorted((float(speeds[n - 1]), float(speeds[n])))
    return float(brentq(through, low, high))


def _peak(Omega: float, height: float, before: float | None, after: float | None) -> Peak:
    from_single_side = before is None or after is None
    ends = [speed for speed in (before, after) if speed is not None]
    width = 2.0 * abs(Omega - ends[0]) if from_single_side else ends[1] - ends[0]
    return Peak(Omega, height, Omega / max(width, math.ulp(Omega)), from_single_side)


def separation_margin(Omega: float, lowest: float, highest: float) -> float:
    """Return the distance (%) of a critical speed from the nearer end of the operating range; negative inside it."""
    if Omega < lowest:
        return 100.0 * (lowest - Omega) / lowest
    if Omega > highest:
        return 100.0 * (Omega - highest) / highest
    return -100.0 * min((Omega - lowest) / lowest, (highest - Omega) / highest)
