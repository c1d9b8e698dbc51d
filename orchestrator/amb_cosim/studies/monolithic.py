"""The levitated rotor as a whole, between samples of its controller: what a co-simulation of the parts is held against.

Nothing here is shared with the plant's kernels or the master. The reduced rotor is taken in complex coordinates
r = x + i y,

    M r'' - i Omega G_1 r' + (K - B K_s B^T) r = Omega^2 u exp(i theta) + B (F + N)
    C = -(K_b + K_s) r_n - C_b (r_n - r_(n-1)) / T,  constant between samples
    F = C, or with an amplifier F' = omega_b (C - F)

with N = 0 for the linear law, and for the law (2.6) what it exceeds K_s r + F by.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from amb_actuator.force import Coils, nonlinear_force
from amb_analysis.design import axis_parameters
from rotor_analysis.assembly import assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor_file import load_rotor

Complex = NDArray[np.complex128]

BEARINGS = [2, 4]  # among the masters, nodes 1, 3, 4, 10, 11, 13
DISCS = {"d1": 0, "d2": 1, "d3": 3, "d4": 5}


@dataclass(frozen=True)
class Case:
    """Speed (rad/s), unbalance (kg m) at `disc`, constants of bearing and controller (SI).

    k_i
        Current stiffness (N/A); it matters only where something depends on the current itself.
    delay
        Samples by which a current comes later than the displacement that it answers.
    bandwidth
        Of the amplifiers (Hz); None if the currents are there at once.
    nonlinear
        The force follows (2.6) with saturation; K_s and K_i are then what the controller knows of it.
    """

    Omega: float
    disc: str
    unbalance: float
    k_s: float = 2e6
    k_i: float = 1e4
    k_b: float = 1e6
    c_b: float = 5000.0
    sample_time: float = 250e-6
    delay: int = 0
    bandwidth: float | None = None
    nonlinear: bool = False


class Levitated:
    """The extended linear system z = (r, r', exp(i theta), F_1, F_2, C_1, C_2): all forcings are states, too."""

    def __init__(self, case: Case) -> None:
        rotor = load_rotor()
        reduced = msdc(assemble(rotor, "diagonal"), rotor.planes.master).model
        M, K, G_1 = reduced.M[::2, ::2], reduced.K[::2, ::2], reduced.G[::2, 1::2]
        self.case, self.n = case, len(M)
        n = self.n
        self.Minv = np.linalg.inv(M)
        B = np.eye(n)[:, BEARINGS]
        push = np.zeros(n)
        push[DISCS[case.disc]] = case.Omega**2
        self.force = slice(2 * n + 1, 2 * n + 3)
        self.command = slice(2 * n + 3, 2 * n + 5)
        self.A = np.zeros((2 * n + 5, 2 * n + 5), dtype=complex)
        self.A[:n, n : 2 * n] = np.eye(n)
        self.A[n : 2 * n, :n] = -self.Minv @ (K - case.k_s * B @ B.T)
        self.A[n : 2 * n, n : 2 * n] = 1j * case.Omega * self.Minv @ G_1
        self.A[n : 2 * n, 2 * n] = self.Minv @ push * case.unbalance
        self.A[n : 2 * n, self.force] = self.Minv @ B
        self.A[2 * n, 2 * n] = 1j * case.Omega
        if case.bandwidth is not None:
            omega = 2.0 * math.pi * case.bandwidth
            self.A[self.force, self.force] = -omega * np.eye(2)
            self.A[self.force, self.command] = omega * np.eye(2)
        self.z = np.zeros(2 * n + 5, dtype=complex)
        self.z[2 * n] = 1.0
        self.before = self.bearings
        self._on_their_way = deque([np.zeros(2, dtype=complex)] * case.delay)

    @property
    def bearings(self) -> Complex:
        """Complex displacement at MB1 and MB2 (m)."""
        return self.z[BEARINGS].copy()

    def sample(self) -> None:
        """The PID law takes a sample and holds its force."""
        case, now = self.case, self.bearings
        self._on_their_way.append(-(case.k_b + case.k_s) * now - case.c_b * (now - self.before) / case.sample_time)
        self.z[self.command] = self._on_their_way.popleft()
        if case.bandwidth is None:
            self.z[self.force] = self.z[self.command]
        self.before = now


def free_orbit(case: Case, samples: int) -> Complex:
    """Complex displacement at MB1 and MB2 (m) at each sample, from rest and without contact, shape (samples + 1, 2).

    Between samples the extended system is linear, and its matrix exponential advances it without error; with the
    law (2.6) it is integrated to tight tolerances.
    """
    system = Levitated(case)
    advance = expm(system.A * case.sample_time)
    orbit = [system.bearings]
    for _ in range(samples):
        system.sample()
        system.z = _integrated(system) if case.nonlinear else advance @ system.z
        orbit.append(system.bearings)
    return np.array(orbit)


def _integrated(system: Levitated) -> Complex:
    """State of the nonlinear system at the next sample."""
    n, case = system.n, system.case
    p = axis_parameters()

    def beyond_linear(x: float, force: float) -> float:
        i_c = force / case.k_i
        exact, _ = nonlinear_force(p, x, Coils(i_c, i_c, 1.0, 1.0))
        return exact - case.k_s * x - force

    def rate(_: float, z: Complex) -> Complex:
        dz = system.A @ z
        for row, f in zip(BEARINGS, z[system.force], strict=True):
            extra = beyond_linear(z[row].real, f.real) + 1j * beyond_linear(z[row].imag, f.imag)
            dz[n : 2 * n] += system.Minv[:, row] * extra
        return dz

    part = solve_ivp(rate, (0.0, case.sample_time), system.z, "DOP853", rtol=1e-10, atol=1e-14)
    end: Complex = part.y[:, -1]
    return end
