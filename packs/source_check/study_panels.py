"""Plots of studies, as data."""

from __future__ import annotations

from typing import Any

import numpy as np

from amb_analysis.studies.campbell_diagram import CampbellDiagram
from amb_analysis.studies.natural_modes import ModeShapes
from amb_analysis.studies.sensor_receptance import SensorReceptance
from amb_assessment.reporting.panels import Panel, curve

DRAWN_MODES = 8


def campbell_panels(result: CampbellDiagram) -> list[Panel]:
    """Return a plot of natural frequencies against spin speed, with the line of synchronous speed."""
    modes = [curve(f"mode {k}", result.speeds, mode.frequencies) for k, mode in enumerate(result.modes, start=1)]
    synchronous = curve("synchronous", result.speeds, result.speeds, "dashed")
    return [Panel("Damped natural frequencies", "spin speed (rad/s)", "frequency (rad/s)", (*modes, synchronous))]


def mode_panels(result: ModeShapes) -> list[Panel]:
    """Return a plot of the mode shapes along the shaft, for the lowest four pairs of modes."""
    frequencies, shapes = result.frequencies.speeds[result.speed].frequencies, result.shapes[result.speed]
    return [
        Panel(
            f"Mode shapes at {result.speed:g} rad/s",
            "axial position (m)",
            "displacement in x",
            tuple(
                curve(f"{frequencies[k]:.1f} rad/s", result.z, _real(shapes[k].x))
                for k in range(0, min(DRAWN_MODES, len(shapes)), 2)
            ),
        )
    ]


def receptance_panels(result: SensorReceptance) -> list[Panel]:
    """Return a plot of the norm of each column of the receptance against spin speed (5.18)."""
    norms = 1e6 * np.linalg.norm(result.receptance, axis=1)
    curves = tuple(curve(name, result.spin_frequencies, norms[:, k]) for k, name in enumerate(result.forces))
    return [Panel("Norm of the columns of R", "spin speed (Hz)", "|R_i| (um/N)", curves)]


def _real(shape: Any) -> Any:
    """Return the real part of a complex shape that is rotated so that its largest displacement is positive."""
    largest = shape[int(np.argmax(np.abs(shape)))]
    return np.real(shape * np.conj(largest)) / abs(largest)
