"""Hysteretic damping of the shaft: a force that depends on loss factor and strain, not on the bending frequency.

The share r of the loss factor eta belongs to damping that rotates with the shaft and opposes strain in its frame. A
forward or backward whirl of frequency omega in the fixed frame bends the fibres of the shaft at the frequency omega -
Omega or -omega - Omega, respectively. In a harmonic motion q = Re[Q exp(i omega t)] the force of the shaft's damping is
-D Q with

    D = i eta (1 - r) sgn(omega) K + i eta r K (sgn(omega - Omega) P_f + sgn(omega + Omega) P_b)           (1)
    P_f = (1 - i J)/2,   P_b = (1 + i J)/2

where K is the stiffness of the shaft alone, J turns each pair x, y by a right angle from x to y, and P_f and P_b
project onto the forward and the backward part of the motion. For motion faster than the spin, D is i eta K, so each
cycle dissipates 2 pi eta times the maximum strain energy. For slower motion with r = 1, D is -sgn(Omega) eta K J; its
force on a forward whirl has the direction of the velocity and drives this whirl. Synchronous forward whirl leaves the
strain constant and dissipates nothing.

A time-domain model requires a force that depends on positions and velocities. For a free rotor with K phi_k = omega_k^2
M phi_k and phi_k^T M phi_k = 1, this force is due to viscous damping with the same loss in each mode at rest,

    C_i = eta sum_k omega_k (M phi_k)(M phi_k)^T.                                                          (2)

Source: G. Genta, Dynamics of Rotating Systems, 2005.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from array_types import Array, Complex
from rotor_analysis.damping import free_modes
from rotor_analysis.pairs import times_turned


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """Hysteretic damping (1) of a shaft.

    loss_factor, rotating
        eta and r.
    K
        Stiffness of the shaft without bearings, in the coordinates of a model, shape (size, size).
    """

    loss_factor: float
    rotating: float
    K: Array

    def reduced(self, right: Array, left: Array) -> Hysteresis:
        """Return the same damping in the coordinates of a reduced model (`reduction.Reduction`)."""
        return replace(self, K=left @ self.K @ right)

    def stiffness(self, omega: float, Omega: float) -> Complex | Array:
        """Return D of (1) in N/m at a frequency and a spin speed (rad/s), as a real array if D is real."""
        forward, backward = np.sign(omega - Omega), np.sign(omega + Omega)
        fixed, turning = self.loss_factor * (1.0 - self.rotating), self.loss_factor * self.rotating
        loss = fixed * np.sign(omega) + 0.5 * turning * (forward + backward)
        drive = 0.5 * turning * (forward - backward) * times_turned(self.K)
        return np.asarray(drive + 1j * loss * self.K if loss else drive)

    def viscous(self, M: Array) -> tuple[Array, Array]:
        """Return the shares of C_i (2) in the fixed and rotating frames (N s/m); M is the free rotor's mass matrix."""
        frequencies, shapes = free_modes(M[::2, ::2], self.K[::2, ::2])
        momenta = M[::2, ::2] @ shapes
        C: Array = np.kron(self.loss_factor * (momenta * frequencies) @ momenta.T, np.eye(2)).astype(np.float64)
        return (1.0 - self.rotating) * C, self.rotating * C
