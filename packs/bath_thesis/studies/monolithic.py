"""Monolithic model of the levitated rig: the reference for a co-simulation of its parts.

The model shares no code with the plant's kernels or the master. The reduced rotor is described by complex coordinates
r = x + i y,

    M r'' - i Omega G_1 r' + (K - B K_s B^T) r = Omega^2 u exp(i theta) + B (F + N)
    C = -(K_b + K_s) r_n - C_b (r_n - r_(n-1)) / T,  constant between samples
    F = C, or with an amplifier F' = omega_b (C - F)

Here, N is 0 for the linear law. For the law (2.6), N is the difference between the force and K_s r + F.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from amb_actuator.force import Coils, nonlinear_force
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from array_types import Complex
from rotor_analysis.assembly import assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor_file import load_rotor

# Rows of the bearings and discs among the master nodes 1, 3, 4, 10, 11, 13.
BEARINGS = [2, 4]
DISCS = {"d1": 0, "d2": 1, "d3": 3, "d4": 5}


@dataclass(frozen=True)
class Levitation:
    """A levitated rotor: spin speed (rad/s), unbalance (kg m) at `disc`, and SI constants of bearings and controller.

    k_i
        Current stiffness (N/A), which only the law (2.6) needs, because this law depends on the current itself.
    bandwidth
        Bandwidth of the amplifiers (Hz); None for ideal amplifiers.
    nonlinear
        Whether the force follows (2.6) with saturation; K_s and K_i are then the constants that the controller assumes.
    """

    Omega: float
    disc: str
    unbalance: float
    k_s: float = 2e6
    k_i: float = 1e4
    k_b: float = 1e6
    c_b: float = 5000.0
    sample_time: float = 250e-6
    bandwidth: float | None = None
    nonlinear: bool = False


class MonolithicSystem:
    """Extended linear system, whose states z = (r, r', exp(i theta), F_1, F_2, C_1, C_2) include all excitations."""

    def __init__(self, levitation: Levitation) -> None:
        rotor = load_rotor()
        reduced = msdc(assemble(rotor, "diagonal"), rotor.masters).model
        M, K, G_1 = reduced.M[::2, ::2], reduced.K[::2, ::2], reduced.G[::2, 1::2]
        self.levitation, self.n = levitation, len(M)
        n = self.n
        self.Minv = np.linalg.inv(M)
        B = np.eye(n)[:, BEARINGS]
        synchronous_force = np.zeros(n)
        synchronous_force[DISCS[levitation.disc]] = levitation.Omega**2
        self.force = slice(2 * n + 1, 2 * n + 3)
        self.command = slice(2 * n + 3, 2 * n + 5)
        self.A = np.zeros((2 * n + 5, 2 * n + 5), dtype=complex)
        self.A[:n, n : 2 * n] = np.eye(n)
        self.A[n : 2 * n, :n] = -self.Minv @ (K - levitation.k_s * B @ B.T)
        self.A[n : 2 * n, n : 2 * n] = 1j * levitation.Omega * self.Minv @ G_1
        self.A[n : 2 * n, 2 * n] = self.Minv @ synchronous_force * levitation.unbalance
        self.A[n : 2 * n, self.force] = self.Minv @ B
        self.A[2 * n, 2 * n] = 1j * levitation.Omega
        if levitation.bandwidth is not None:
            omega = 2.0 * math.pi * levitation.bandwidth
            self.A[self.force, self.force] = -omega * np.eye(2)
            self.A[self.force, self.command] = omega * np.eye(2)
        self.z = np.zeros(2 * n + 5, dtype=complex)
        self.z[2 * n] = 1.0
        self.previous = self.bearings

    @property
    def bearings(self) -> Complex:
        """Complex displacement at the two bearings (m)."""
        return self.z[BEARINGS].copy()

    def sample(self) -> None:
        """Sample the displacements, and set the force of the PID law, which is held until the next sample."""
        levitation, displacement = self.levitation, self.bearings
        difference = displacement - self.previous
        stiffness, damping = levitation.k_b + levitation.k_s, levitation.c_b
        self.z[self.command] = -stiffness * displacement - damping * difference / levitation.sample_time
        if levitation.bandwidth is None:
            self.z[self.force] = self.z[self.command]
        self.previous = displacement


def free_orbit(levitation: Levitation, samples: int) -> Complex:
    """Return the complex displacement (m) at both bearings and each sample, from rest, shape (samples + 1, 2).

    The model has no contact. Between samples, the extended system is linear, so its matrix exponential advances it
    without error. With the law (2.6), the system is integrated to tight tolerances instead.
    """
    system = MonolithicSystem(levitation)
    advance = expm(system.A * levitation.sample_time)
    orbit = [system.bearings]
    for _ in range(samples):
        system.sample()
        system.z = _integrated(system) if levitation.nonlinear else advance @ system.z
        orbit.append(system.bearings)
    return np.array(orbit)


def _integrated(system: MonolithicSystem) -> Complex:
    """Return the state of the nonlinear system at the next sample."""
    n, levitation = system.n, system.levitation
    p = axis_parameters()

    def beyond_linear(x: float, force: float) -> float:
        i_c = force / levitation.k_i
        exact, _ = nonlinear_force(p, x, Coils(i_c, i_c, 1.0, 1.0))
        return exact - levitation.k_s * x - force

    def rate(_: float, z: Complex) -> Complex:
        dz = system.A @ z
        for row, f in zip(BEARINGS, z[system.force], strict=True):
            extra = beyond_linear(z[row].real, f.real) + 1j * beyond_linear(z[row].imag, f.imag)
            dz[n : 2 * n] += system.Minv[:, row] * extra
        return dz

    motion = solve_ivp(rate, (0.0, levitation.sample_time), system.z, "DOP853", rtol=1e-10, atol=1e-14)
    end: Complex = motion.y[:, -1]
    return end
