"""Frequency responses of a controller, sampled and continuous, from each measured signal to each demand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_cosim.controllers.laws import Law
from amb_cosim.controllers.linear_controller import LinearController
from array_types import Array, Complex

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


def phase_at(path: LawPath, omega: Array, frequency: float) -> float:
    """Return the phase of the sampled law at a frequency (rad/s), from -180 to 180 degrees."""
    return float((np.interp(frequency, omega, degrees(path.sampled)) + 180.0) % 360.0 - 180.0)


def degrees(values: Complex) -> Array:
    """Return the phase of a response in degrees, without jumps."""
    return np.asarray(np.degrees(np.unwrap(np.angle(values))))
