"""Sensitivity of a sampled loop over frequency, with its peaks."""

from __future__ import annotations

import control
import numpy as np

from amb_analysis.linear.loop import pole_frequency
from amb_analysis.linear.responses import Modes, diagonal_response, modes_of
from amb_analysis.studies.injection import HIGHEST, LOWEST
from array_types import Array, Complex
from rotor_analysis.refinement import refined

POINTS = 2000  # of the computed curve
SHARP = 0.1  # damping ratio up to which a resonance is sharp
ANGLES = np.linspace(-1.45, 1.45, 73)  # of the points about a sharp resonance (rad)


def curve_frequencies(
    poles: Array | Complex, sample_time: float, lowest: float = LOWEST, highest: float = HIGHEST
) -> Array:
    """Return the frequencies (Hz) of the computed curve, evenly spaced on a logarithmic axis and denser near the poles.

    Near a pole s = -sigma + i omega, the response moves on a circle; the frequencies omega + sigma tan(psi) with evenly
    spaced psi give evenly spaced points on this circle.
    """
    highest = min(highest, 0.5 / sample_time)
    growth = np.abs(poles)
    sigma = -np.log(np.where(growth > 0.0, growth, 1.0)) / (2.0 * np.pi * sample_time)  # Hz
    resonances = np.asarray(pole_frequency(poles, sample_time))
    close = resonances[:, None] + np.where(sigma < SHARP * resonances, sigma, 0.0)[:, None] * np.tan(ANGLES)
    within = close[(close >= lowest) & (close <= highest)]
    return np.unique(np.concatenate([np.geomspace(lowest, highest, POINTS), within]))


def sensitivity_curves(
    system: control.StateSpace, lowest: float = LOWEST, highest: float = HIGHEST, modes: Modes | None = None
) -> tuple[Array, Complex]:
    """Return frequencies (Hz), refined at the peaks of all axes, and S of each axis at them, shape (axes, n).

    Parameters
    ----------
    system
        Sensitivity of a stable sampled loop.
    lowest, highest
        Lowest and highest frequency (Hz); neither may exceed half the sample rate.
    modes
        Modes of the system, if they are known.
    """
    modes = modes or modes_of(system)
    poles = system.poles() if modes is None else modes.poles
    frequencies, curves = refined(
        lambda more: diagonal_response(system, more, modes).T,
        curve_frequencies(poles, float(system.dt), lowest, highest),
        np.abs,
    )
    return frequencies, np.asarray(curves.T)


def bands(sample_time: float) -> list[tuple[float, float]]:
    """Return the frequency range (Hz) of the standard, and any range between its end and half the sample rate."""
    nyquist = 0.5 / sample_time
    return [(LOWEST, min(HIGHEST, nyquist)), *([(HIGHEST, nyquist)] if nyquist > HIGHEST * (1.0 + 1e-9) else [])]


def sensitivity_bands(system: control.StateSpace) -> list[tuple[Array, Complex]]:
    """Return the `sensitivity_curves` of each of the `bands`."""
    modes = modes_of(system)
    return [sensitivity_curves(system, *band, modes) for band in bands(float(system.dt))]


def peaks_of(frequencies: Array, curves: Array | Complex) -> list[tuple[float, float]]:
    """Return the largest |S| of each axis, and its frequency (Hz), from the curves of all axes, shape (axes, n)."""
    return [(float(np.abs(S).max()), float(frequencies[np.abs(S).argmax()])) for S in curves]
