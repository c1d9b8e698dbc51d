"""Poles and sensitivities of the sampled loop with many controllers, computed from one plant model at each speed.

    x(n+1) = A x(n) + B i(n),   y(n) = C x(n),   G(z) = C (z - A)^-1 B                              (1)
    i = K(z) y + e   =>   i = S e,   S = (1 - K G)^-1,   poles: eigenvalues of the loop of (1) and K  (2)

i contains the demanded currents, which are held for a sample, and y contains the displacements at the sensors. The
diagonal of S contains the sensitivity of each axis with the loops of all other axes closed (ISO 14839-3). K is the law
of the controller's linear model, including the delay and the filter of the controller.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amb_analysis.linear.components import StateSpace, frequency_response
from amb_analysis.linear.control import pid_component
from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.loop import Loop
from amb_analysis.linear.responses import Modes, modes_of
from amb_analysis.studies.injection import HIGHEST, LOWEST
from amb_analysis.studies.sensitivity_curves import curve_frequencies
from amb_cosim.controllers.laws import Law
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from array_types import Array, Complex
from rotor_analysis.refinement import refined

COARSE = 60  # frequencies of the search, in addition to those about poles
ABOUT = (-1.0, -0.3, 0.3, 1.0)  # distances of frequencies from a pole over its decay rate
LIGHTLY = 0.8  # modulus above which a pole has a peak
VIBRATES = 1.0  # rad/s, least frequency of a vibration


@dataclass(frozen=True)
class Peak:
    """Largest |S|, with its axis, frequency (Hz) and spin speed (rad/s)."""

    value: float
    axis: str = ""
    frequency: float = 0.0
    speed: float = 0.0


class SampledPlant(NamedTuple):
    """Rotor, magnets and amplifiers at a spin speed (rad/s) as the sampled system (1), and its modes."""

    Omega: float
    system: StateSpace
    modes: Modes

    def closed(self, law: Law) -> Array:
        """Return the state matrix of the loop that the plant (1) forms with a control law."""
        A, B, C = self.system.A, self.system.B, self.system.C
        return np.block([[A + B @ law.D @ C, B @ law.C], [law.B @ C, law.A]])


class LoopSearch:
    """The sampled loop of a machine at several speeds, for any law of its PID.

    Parameters
    ----------
    loop
        Loop of the machine, with any gains.
    speeds
        Spin speeds (rad/s).
    """

    def __init__(self, loop: Loop, speeds: Sequence[float]) -> None:
        self.axes, self.sample_time = loop.axis_names, loop.sample_time
        self._ends = loop.readings, loop.sources
        self._layout = loop.linear_components.layout(CONTROLLER)
        self.parameters = loop.linear_components.parameters(CONTROLLER)
        self.plants = [_sampled(loop, Omega) for Omega in speeds]
        self._hertz = np.geomspace(LOWEST, 0.5 / self.sample_time, COARSE)
        self._responses = [plant.modes.response(self._z(self._hertz)) for plant in self.plants]

    def law(self, gains: Mapping[str, float]) -> Law:
        """Return the law of the PID with other gains, which are given by parameter name."""
        part = pid_component(CONTROLLER, self._layout, {**self.parameters, **gains})
        return part.selected(*self._ends).law

    def poles(self, law: Law) -> list[Complex]:
        """Return the poles z of the loop at each speed."""
        return [np.linalg.eigvals(plant.closed(law)).astype(np.complex128) for plant in self.plants]

    def coarse_peaks(self, law: Law, poles: Sequence[Complex]) -> tuple[float, float]:
        """Return the largest |S| of any axis and speed up to 2 kHz, and above, on a coarse grid and near poles."""
        low = high = 0.0
        K = frequency_response(law, self._z(self._hertz))
        for plant, G, z in zip(self.plants, self._responses, poles, strict=True):
            hertz = self._about(z)
            points = self._z(hertz)
            about = _sensitivity(frequency_response(law, points), plant.modes.response(points))
            S = np.vstack([_sensitivity(K, G), about]).max(axis=1)
            within = np.concatenate([self._hertz, hertz]) <= HIGHEST
            low, high = max(low, float(S[within].max())), max(high, float(S[~within].max(initial=0.0)))
        return low, high

    def _about(self, z: Complex) -> Array:
        """Return frequencies (Hz) near the poles of lightly damped vibrations, up to half the sample rate."""
        s = np.log(z[(z.imag > 0.0) & (np.abs(z) > LIGHTLY)]) / (2.0 * math.pi * self.sample_time)
        hertz = (s.imag[:, None] + s.real[:, None] * np.array(ABOUT)).ravel()
        return hertz[(hertz >= LOWEST) & (hertz <= 0.5 / self.sample_time)]

    def peaks(self, law: Law) -> tuple[Peak, Peak]:
        """Return the largest |S| up to 2 kHz, and above 2 kHz, on a frequency grid that is dense near each pole."""
        by_speed = [(Peak(0.0), Peak(0.0))]
        for plant, z in zip(self.plants, self.poles(law), strict=True):
            hertz = curve_frequencies(z, self.sample_time, LOWEST, 0.5 / self.sample_time)
            points = self._z(hertz)
            S = _sensitivity(frequency_response(law, points), plant.modes.response(points))
            by_speed.append(
                (self._largest(plant, hertz, S, hertz <= HIGHEST), self._largest(plant, hertz, S, hertz > HIGHEST))
            )
        low, high = (max(band, key=lambda peak: peak.value) for band in zip(*by_speed, strict=True))
        return low, high

    def _largest(self, plant: SampledPlant, hertz: Array, S: Array, within: NDArray[np.bool_]) -> Peak:
        if not within.any():
            return Peak(0.0)
        band, rows = S[within], hertz[within]
        row, axis = np.unravel_index(band.argmax(), band.shape)
        return Peak(float(band[row, axis]), self.axes[axis], float(rows[row]), plant.Omega)

    def _z(self, hertz: Array) -> Complex:
        return np.exp(2j * math.pi * self.sample_time * hertz)


def largest_peaks(loop: Loop, gains: Mapping[str, float], speeds: Array) -> tuple[Peak, Peak]:
    """Return the largest |S| up to 2 kHz, and above 2 kHz, at any speed from the first to the last of `speeds`.

    Parameters
    ----------
    loop
        Loop of the machine, which must be stable with these gains.
    gains
        Gains of the PID, by parameter name.
    speeds
        Ascending speeds (rad/s), between which each maximum is refined, shape (n,).
    """
    by_speed: list[tuple[Peak, Peak]] = []

    def values(more: Array) -> Array:
        for Omega in map(float, more):
            search = LoopSearch(loop, [Omega])
            by_speed.append(search.peaks(search.law(gains)))
        return np.array([[low.value, high.value] for low, high in by_speed[len(by_speed) - len(more) :]])

    refined(values, speeds, lambda peaks: peaks, resonant=False)
    low, high = (max(band, key=lambda peak: peak.value) for band in zip(*by_speed, strict=True))
    return low, high


def damping_ratios(z: Complex, sample_time: float) -> tuple[Array, Array]:
    """Return the frequencies (rad/s) and damping ratios -Re s/|s| of the vibrations among the poles z = exp(s T)."""
    s = np.log(z[np.abs(z) > 1e-9]) / sample_time
    s = s[s.imag > VIBRATES]
    return s.imag, np.asarray(-s.real / np.abs(s))


def _sampled(loop: Loop, Omega: float) -> SampledPlant:
    source = loop.linear_components.at(Omega)
    sources = [source.plan.system.source_of(reading) or "" for reading in loop.readings]
    model = model_of(source, loop.demands, sources, [PLANT, ACTUATOR])
    system = model.sample(loop.sample_time)
    modes = modes_of(system)
    if modes is None:
        raise ValueError(f"the plant at {Omega:g} rad/s has no eigenvectors")
    return SampledPlant(Omega, system, modes)


def _sensitivity(K: Complex, G: Complex) -> Array:
    """Return |S| of the axes according to (2), shape (n, axes)."""
    S = np.linalg.inv(np.eye(K.shape[1]) - K @ G)
    return np.abs(np.einsum("nkk->nk", S))
