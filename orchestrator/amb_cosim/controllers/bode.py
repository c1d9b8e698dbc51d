"""Frequency responses of a controller, sampled and continuous, from each measured signal to each demand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from amb_cosim.controllers.laws import Law
from amb_cosim.controllers.linear_controller import LinearController
from array_types import Array, Complex

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOWEST, POINTS = 1e-4, 600  # lowest frequency over half the sampling frequency, and number of frequencies


@dataclass(frozen=True)
class LawPath:
    """A connection from a signal to a demand: sampled and, if known, continuous frequency responses."""

    signal: str
    demand: str
    sampled: Complex
    continuous: Complex | None


def response(law: Law, omega: Array, sample_time: float | None) -> Complex:
    """Return C (p 1 - A)^-1 B + D with p = exp(j omega T), or j omega without T; shape (n, n_demands, n_signals)."""
    p = 1j * omega if sample_time is None else np.exp(1j * omega * sample_time)
    item = np.eye(len(law.A))  # for all frequencies at once, the matrices of a large law would fill the memory
    return np.asarray([law.C @ np.linalg.solve(point * item - law.A, law.B) + law.D for point in p])


def frequencies(controller: LinearController) -> Array:
    """Return angular frequencies up to half the sampling frequency (rad/s)."""
    nyquist = np.pi / controller.sample_time
    return np.asarray(np.geomspace(LOWEST * nyquist, 0.999 * nyquist, POINTS))


def connections(controller: LinearController, omega: Array, speed: float, continuous: Law | None) -> list[LawPath]:
    """Return the connections of a controller at a speed of its table, with that of its continuous law if any.

    Both include the controller's `delay`, exp(-j omega delay T) for the sampled law.
    """
    late = np.exp(-1j * omega * controller.sample_time * controller.starts.get("delay", 0.0))[:, None, None]
    result = late * response(controller.laws[speed], omega, controller.sample_time)
    before = None if continuous is None else late * response(continuous, omega, None)
    return [
        LawPath(signal, demand, result[:, i, j], None if before is None else before[:, i, j])
        for i, demand in enumerate(controller.ports.demands)
        for j, signal in enumerate(controller.ports.signals)
        if np.any(np.abs(result[:, i, j]) > 1e-12 * np.abs(result).max())
    ]


def draw(laws: Sequence[LawPath], omega: Array, modes: Sequence[float]) -> Figure:
    """Return Bode plots: sampled solid, continuous dashed, modes (rad/s) as lines.

    Connections with equal responses share a line.
    """
    from amb_cosim.presentation.style import DASHED, GREY, StyledFigure

    figure = StyledFigure(figsize=(8.0, 6.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    hertz = omega / (2.0 * np.pi)
    for number, (names, path) in enumerate(_grouped(laws)):
        colour, label = f"C{number}", ", ".join(names[:4]) + (" ..." if len(names) > 4 else "")
        above.loglog(hertz, np.abs(path.sampled), color=colour, label=label)
        below.semilogx(hertz, _degrees(path.sampled), color=colour)
        if path.continuous is not None:
            above.loglog(hertz, np.abs(path.continuous), color=colour, linestyle=DASHED)
            below.semilogx(hertz, _degrees(path.continuous), color=colour, linestyle=DASHED)
    for axes in (above, below):
        for mode in modes:
            axes.axvline(mode / (2.0 * np.pi), color=GREY, linewidth=0.6)
        axes.grid(alpha=0.3)
    above.set(ylabel="gain (A/m)")
    below.set(xlabel="frequency (Hz)", ylabel="phase (deg)")
    above.legend(loc="best")
    available = any(path.continuous is not None for path in laws)
    figure.suptitle("Sampled" + (", dashed: continuous" if available else "") + ("; grey: modes" if modes else ""))
    return figure


def phase_at(path: LawPath, omega: Array, frequency: float) -> float:
    """Return the phase of the sampled law at a frequency (rad/s), from -180 to 180 degrees."""
    return float((np.interp(frequency, omega, _degrees(path.sampled)) + 180.0) % 360.0 - 180.0)


def _degrees(values: Complex) -> Array:
    return np.asarray(np.degrees(np.unwrap(np.angle(values))))


def _grouped(laws: Sequence[LawPath]) -> list[tuple[list[str], LawPath]]:
    groups: list[tuple[list[str], LawPath]] = []
    for path in laws:
        name = f"{path.signal} to {path.demand}"
        for names, first in groups:
            if np.allclose(first.sampled, path.sampled, rtol=1e-9, atol=0.0):
                names.append(name)
                break
        else:
            groups.append(([name], path))
    return groups
