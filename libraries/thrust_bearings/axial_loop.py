"""The sampled loop of a rigid rotor in a thrust bearing: its poles and its sensitivity.

    m z'' = F + f_z,   F = G_n(s) (K_i i_c + K_s z),   i_c' = omega_b (i - i_c)                    (1)

with the lag G_n of the eddy currents and the amplifier's bandwidth omega_b. The controller reads z at the instants k T
and demands u_k = C x_k + D z_k, x_k+1 = A x_k + B z_k. The demand is held for a sample, d = n + f samples later:

    i(t) = u_k-n-1   for k T <= t < (k + f) T,      u_k-n   for (k + f) T <= t < (k + 1) T         (2)

Between these instants matrix exponentials give the exact states. As K_i > 0, feedback that returns the rotor is
negative: a demand i < 0 at z > 0. With the loop gain L of the negative feedback, opened at the demand, the sensitivity
is S = 1/(1 + L) (ISO 14839-3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm

from amb_files.checks import require, require_positive
from array_types import Array, Complex
from thrust_bearings.rational_lag import NO_LAG, RationalLag

Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class AxialPlant:
    """A rigid rotor in its thrust bearing, with current demands as input.

    mass
        m (kg).
    k_i, k_s
        K_i (N/A) and K_s (N/m).
    bandwidth
        Bandwidth omega_b of the amplifier (rad/s).
    lag
        Lag of the eddy currents; none with laminated iron.
    """

    mass: float
    k_i: float
    k_s: float
    bandwidth: float
    lag: RationalLag = NO_LAG

    def __post_init__(self) -> None:
        require_positive(self, mass="kg", k_i="N/A", k_s="N/m", bandwidth="rad/s")

    @cached_property
    def matrices(self) -> tuple[Array, Array]:
        """A and B of (1) in the states z, z', i_c and those of the lag; z is the first one."""
        lag, gain, c, d = self.lag.state_space()
        n = 3 + len(lag)
        force = np.array([self.k_s, 0.0, self.k_i])  # N, by z, z' and i_c, before the lag
        A, B = np.zeros((n, n)), np.zeros((n, 1))
        A[0, 1] = 1.0
        A[1, :3] = d[0, 0] * force / self.mass
        A[1, 3:] = c[0] / self.mass
        A[2, 2] = -self.bandwidth
        A[3:, :3] = gain * force
        A[3:, 3:] = lag
        B[2] = self.bandwidth
        return A, B


@dataclass(frozen=True)
class AxialLoop:
    """The closed sampled loop.

    plant
        Rotor, bearing, amplifier.
    controller
        A, B, C, D of the sampled law from z (m) to the demanded current (A).
    sample_time
        T (s).
    delay
        d, in samples.
    """

    plant: AxialPlant
    controller: Matrices
    sample_time: float
    delay: float = 0.0

    def __post_init__(self) -> None:
        require(0.0 < self.sample_time < math.inf, "sample_time", f"{self.sample_time:g} s", "> 0 s")
        require(0.0 <= self.delay < math.inf, "delay", f"{self.delay:g} samples", ">= 0 samples")
        shape = self.controller[3].shape
        require(shape == (1, 1), "controller", f"with D of shape {shape}", "from one signal to one demand, (1, 1)")

    @cached_property
    def sampled_plant(self) -> tuple[Array, Array, Array]:
        """A and B of (2), and C with z as output; the states are those of the plant and the delayed demands."""
        (A, B), T = self.plant.matrices, self.sample_time
        whole, fraction = int(self.delay), self.delay - int(self.delay)
        first, later = zero_order_hold(A, B, fraction * T), zero_order_hold(A, B, (1.0 - fraction) * T)
        n, n_delayed = len(A), whole + (1 if fraction else 0)  # demands from the last sample on
        step, inputs = np.zeros((n + n_delayed, n + n_delayed)), np.zeros((n + n_delayed, 1))
        step[:n, :n] = later[0] @ first[0]
        newest, oldest = later[1], later[0] @ first[1]  # of u_k-n and of u_k-n-1
        for samples, effect in ((whole, newest), (whole + 1, oldest)):
            if samples == 0:
                inputs[:n] += effect
            elif samples <= n_delayed:
                step[:n, n + samples - 1] += effect[:, 0]
        if n_delayed:
            inputs[n] = 1.0
            step[n + 1 :, n:-1] += np.eye(n_delayed - 1)
        output = np.zeros((1, n + n_delayed))
        output[0, 0] = 1.0
        return step, inputs, output

    @cached_property
    def step_matrix(self) -> Array:
        """The closed loop's matrix from a sample to the next one."""
        A, B, C = self.sampled_plant
        K = self.controller
        return np.block([[A + B @ K[3] @ C, B @ K[2]], [K[1] @ C, K[0]]])

    @cached_property
    def poles(self) -> Complex:
        """Poles z of the closed loop; it is stable if all are inside the unit circle."""
        return np.linalg.eigvals(self.step_matrix).astype(np.complex128)

    @property
    def vibrations(self) -> Complex:
        """Oscillating modes s (rad/s) of the closed loop, with z = exp(s T) and Im s > 0, by ascending frequency."""
        s = np.log(self.poles[self.poles.imag > 0.0]) / self.sample_time
        return np.asarray(s[np.argsort(s.imag)])

    def sensitivity(self, frequencies: Array) -> Complex:
        """Return S (1) at frequencies (Hz), shape (n,), at most half the sample rate."""
        z = np.exp(2j * np.pi * np.asarray(frequencies, dtype=np.float64) * self.sample_time)
        A, B, C = self.sampled_plant
        K = self.controller
        return np.asarray(1.0 / (1.0 - response((A, B, C, np.zeros((1, 1))), z) * response(K, z)))


def zero_order_hold(A: Array, B: Array, time: float) -> tuple[Array, Array]:
    """Return exp(A t) and the integral of exp(A s) B over s from 0 to t: the effects of state and constant input."""
    n, m = B.shape
    exponential = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * time)
    return exponential[:n, :n], exponential[:n, n:]


def response(system: Matrices, z: Complex) -> Complex:
    """Return C (z - A)^-1 B + D of a system with one input and one output at complex z, shape (n,)."""
    A, B, C, D = system
    if not len(A):
        return np.full(len(z), D[0, 0], dtype=np.complex128)
    states = np.linalg.solve(z[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B, (len(z), *B.shape)))
    return np.asarray((C @ states)[:, 0, 0] + D[0, 0])
