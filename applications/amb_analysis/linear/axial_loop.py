"""The sampled loop of a rigid rotor in a thrust bearing: its poles and its sensitivity.

    m z'' = F + f_z,   F = G_n(s) (K_i i_c + K_s z),   i_c' = omega_b (i - i_c)                    (1)

with the lag G_n of the eddy currents (`amb_actuator.eddy_currents`) and the amplifier's bandwidth omega_b. The
controller reads z at the instants k T and demands u_k = C x_k + D z_k, x_k+1 = A x_k + B z_k. The demand takes effect d
samples later and is held for one sample.

Because K_i > 0, a restoring feedback is negative: it demands i < 0 if z > 0. The sensitivity is S = 1/(1 + L) (ISO
14839-3), where L is the gain of this negative feedback loop, opened at the demand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from amb_analysis.linear.components import LinearComponent, harmonic_response, loop_of
from amb_analysis.linear.rotor_and_magnets import lag_of
from amb_analysis.linear.stability import OVERDAMPED
from amb_cosim.controllers.laws import Law, delayed, in_series, static
from amb_files.checks import require, require_positive
from array_types import Array, Complex

ALIKE = 1e-6  # relative difference of the responses of laws that are the same
FREQUENCIES = 50  # at which they are compared


@dataclass(frozen=True)
class AxialPlant:
    """A rigid rotor in its thrust bearing, with current demands as input.

    mass
        m (kg).
    k_i, k_s
        K_i (N/A) and K_s (N/m).
    bandwidth
        Bandwidth omega_b of the amplifier (rad/s).
    corner
        Corner frequency of the lag of eddy currents (rad/s); None for laminated iron.
    """

    mass: float
    k_i: float
    k_s: float
    bandwidth: float
    corner: float | None = None

    def __post_init__(self) -> None:
        require_positive(self, mass="kg", k_i="N/A", k_s="N/m", bandwidth="rad/s")

    @cached_property
    def law(self) -> Law:
        """Law (1) from the demand to the displacement; its states are z, z', i_c and the states of the lag."""
        of_force = static(np.array([[self.k_s, self.k_i]]))
        force = of_force if self.corner is None else in_series(of_force, lag_of(self.corner))
        n = 3 + len(force.A)
        A, B = np.zeros((n, n)), np.zeros((n, 1))
        A[0, 1] = 1.0
        A[1, [0, 2]] = force.D[0] / self.mass
        A[1, 3:] = force.C[0] / self.mass
        A[2, 2] = -self.bandwidth
        A[3:, [0, 2]] = force.B
        A[3:, 3:] = force.A
        B[2] = self.bandwidth
        return Law(A, B, np.eye(1, n), np.zeros((1, 1)))


class AxialControl(NamedTuple):
    """Law from z (m) to the demanded current (A), its sample time (s), and the delay of the demand in samples."""

    law: Law
    sample_time: float
    delay: float

    def response(self, frequencies: Array) -> Complex:
        """Return the ratio of the demand to z (A/m) at each of the frequencies (Hz), shape (n,)."""
        omega = 2.0 * np.pi * frequencies
        late = np.exp(-1j * omega * self.sample_time * self.delay)
        return np.asarray(late * harmonic_response(self.law, omega, self.sample_time)[:, 0, 0])

    @property
    def reacts_after(self) -> float:
        """Sample times after which a demand reacts to z: the delay, and samples that the law itself holds back."""
        A, B, C, D = self.law.A, self.law.B, self.law.C, self.law.D
        held, gain, reached = 0, D, B
        while not np.any(gain) and held < len(A):
            held, gain, reached = held + 1, C @ reached, A @ reached
        return self.delay + held

    def differs_from(self, other: AxialControl) -> bool:
        """Return whether the sample times differ, or the responses have a relative difference above `ALIKE`."""
        hertz = np.geomspace(1e-4, 0.5, FREQUENCIES) / self.sample_time
        ours, theirs = self.response(hertz), other.response(hertz)
        is_close = np.abs(ours - theirs) <= ALIKE * np.abs(ours)
        return not (math.isclose(self.sample_time, other.sample_time, rel_tol=1e-9) and bool(is_close.all()))


@dataclass(frozen=True)
class AxialLoop:
    """The closed sampled loop.

    plant
        Rotor, bearing and amplifier.
    controller
        Sampled law from z (m) to the demanded current (A).
    sample_time
        T (s).
    delay
        d, in samples.
    """

    plant: AxialPlant
    controller: Law
    sample_time: float
    delay: float = 0.0

    def __post_init__(self) -> None:
        require(0.0 < self.sample_time < math.inf, "sample_time", f"{self.sample_time:g} s", "> 0 s")
        require(0.0 <= self.delay < math.inf, "delay", f"{self.delay:g} samples", ">= 0 samples")
        shape = self.controller.D.shape
        require(shape == (1, 1), "shape of the controller's D", f"{shape}", "(1, 1), from one signal to one demand")

    @cached_property
    def whole(self) -> Law:
        """The closed loop from injected to demanded currents; it contains the plant, the controller and the delay."""
        samples = math.floor(self.delay)
        law = replace(in_series(self.controller, delayed(1, samples)), sample_time=self.sample_time)
        plant = LinearComponent(self.plant.law, ("demand",), ("z",))
        controller = LinearComponent(law, ("reading",), ("u",), self.delay - samples)
        loop = loop_of([plant, controller], {"reading": "z", "demand": "u"})
        return loop.selected(["demand"], ["demand"]).law

    @cached_property
    def poles(self) -> Complex:
        """Poles z of the closed loop, which is stable if all poles are inside the unit circle."""
        return np.linalg.eigvals(self.whole.A).astype(np.complex128)

    @property
    def vibrations(self) -> Complex:
        """Oscillating modes s (rad/s) of the closed loop, with z = exp(s T) and Im s > 0, in order of frequency.

        Motions that decay too fast to oscillate (`OVERDAMPED`) are left out, because rounding alone may give their
        poles an imaginary part.
        """
        s = np.log(self.poles[self.poles.imag > 0.0]) / self.sample_time
        s = s[-s.real < OVERDAMPED * np.abs(s)]
        return np.asarray(s[np.argsort(s.imag)])

    def sensitivity(self, frequencies: Array) -> Complex:
        """Return the sensitivity S (1) at frequencies (Hz) up to half the sample rate, shape (n,)."""
        omega = 2.0 * np.pi * np.asarray(frequencies, dtype=np.float64)
        return harmonic_response(self.whole, omega, self.sample_time)[:, 0, 0]
