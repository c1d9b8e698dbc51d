"""The levitated rotor integrated as a whole: the reference that the co-simulation is held against.

Nothing here is shared with the kernels or the master. The reduced rotor is taken in complex coordinates r = x + i y,

    M r'' - i Omega G_1 r' + (K - B K_s B^T) r = Omega^2 u exp(i theta) + B F - B n N
    F = -(K_b + K_s) r_n - C_b (r_n - r_(n-1)) / h,  constant between samples
    closed site k: Re(conj(n_k) r_k'') = -|r_k'|^2 / c with n_k = r_k / |r_k|, or N_k = 0 if it is open
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from rotor_contact.assembly import assemble
from rotor_contact.reduction import msdc
from rotor_contact.rotor_file import load_rotor

BEARINGS = [2, 4]  # among the masters, nodes 1, 3, 4, 10, 11, 13
DISCS = {"d1": 0, "d2": 1, "d3": 3, "d4": 5}
CLEARANCE = 0.75e-3


@dataclass(frozen=True)
class Case:
    """Speed (rad/s), unbalance (kg m) at `disc`, bearing and controller constants (SI)."""

    Omega: float
    disc: str
    unbalance: float
    k_s: float = 2e6
    k_b: float = 1e6
    c_b: float = 5000.0
    sample_time: float = 250e-6


class Levitated:
    """The extended linear system z = (r, r', exp(i theta), F_1, F_2): both forcings are states of their own."""

    def __init__(self, case: Case) -> None:
        rotor = load_rotor()
        reduced = msdc(assemble(rotor, "diagonal"), rotor.planes.master).model
        M, K, G_1 = reduced.M[::2, ::2], reduced.K[::2, ::2], reduced.G[::2, 1::2]
        self.case, self.n = case, len(M)
        n = self.n
        self.Minv = np.linalg.inv(M)
        B = np.eye(n)[:, BEARINGS]
        self.push = np.zeros(n)
        self.push[DISCS[case.disc]] = case.Omega**2
        self.push = self.Minv @ self.push
        self.A = np.zeros((2 * n + 3, 2 * n + 3), dtype=complex)
        self.A[:n, n : 2 * n] = np.eye(n)
        self.A[n : 2 * n, :n] = -self.Minv @ (K - case.k_s * B @ B.T)
        self.A[n : 2 * n, n : 2 * n] = 1j * case.Omega * self.Minv @ G_1
        self.A[n : 2 * n, 2 * n] = self.push * case.unbalance
        self.A[n : 2 * n, 2 * n + 1 :] = self.Minv @ B
        self.A[2 * n, 2 * n] = 1j * case.Omega
        self.z = np.zeros(2 * n + 3, dtype=complex)
        self.z[2 * n] = 1.0
        self.before = self.bearings

    @property
    def bearings(self) -> np.ndarray:
        return self.z[BEARINGS].copy()

    def sample(self) -> None:
        """The PID law takes a sample and holds its force."""
        case, now = self.case, self.bearings
        self.z[2 * self.n + 1 :] = -(case.k_b + case.k_s) * now - case.c_b * (now - self.before) / case.sample_time
        self.before = now


def free_orbit(case: Case, samples: int) -> np.ndarray:
    """Complex displacement at MB1 and MB2 (m) at each sample, from rest and without contact: exact.

    Between samples the extended system is linear, and its matrix exponential advances it without error.
    """
    system = Levitated(case)
    advance = expm(system.A * case.sample_time)
    orbit = [system.bearings]
    for _ in range(samples):
        system.sample()
        system.z = advance @ system.z
        orbit.append(system.bearings)
    return np.array(orbit)


def orbit_with_contact(case: Case, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Complex displacement at MB1 and MB2 (m), and normal forces (N), at each sample, from rest.

    Frictionless contact as a constraint with the nodal impact law, integrated to tight tolerances with located events.
    """
    system = Levitated(case)
    n = system.n
    closed: set[int] = set()

    def rate(z: np.ndarray) -> tuple[np.ndarray, dict[int, float]]:
        dz = system.A @ z
        sites = sorted(closed)
        if not sites:
            return dz, {}
        rows = [BEARINGS[k] for k in sites]
        normals = z[rows] / np.abs(z[rows])
        speeds = z[[n + row for row in rows]]
        curvature = -(np.abs(speeds) ** 2) / np.abs(z[rows])
        response = -system.Minv[:, rows] * normals
        wanted = curvature - np.real(np.conj(normals) * dz[[n + row for row in rows]])
        forces = np.linalg.solve(np.real(np.conj(normals)[:, None] * response[rows]), wanted)
        dz[n : 2 * n] += response @ forces
        return dz, dict(zip(sites, forces.tolist(), strict=True))

    def right_hand_side(_: float, z: np.ndarray) -> np.ndarray:
        return rate(z)[0]

    def event_of(k: int):  # type: ignore[no-untyped-def]
        def event(_: float, z: np.ndarray) -> float:
            if k in closed:
                return 1e-3 * rate(z)[1][k] + 1e-12
            return 1.0 - abs(z[BEARINGS[k]]) / CLEARANCE

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        return event

    def change(k: int) -> None:
        if k in closed:
            closed.discard(k)
            return
        row = BEARINGS[k]
        normal = system.z[row] / abs(system.z[row])
        system.z[row] = normal * CLEARANCE
        system.z[n + row] -= normal * np.real(np.conj(normal) * system.z[n + row])
        closed.add(k)
        if rate(system.z)[1][k] < 0.0:
            closed.discard(k)

    orbit, force = [system.bearings], [np.zeros(2)]
    for _ in range(samples):
        system.sample()
        forces = rate(system.z)[1]
        while any(value < 0.0 for value in forces.values()):
            closed.discard(min(forces, key=forces.__getitem__))
            forces = rate(system.z)[1]
        time = 0.0
        while time < case.sample_time:
            events = [event_of(0), event_of(1)]
            part = solve_ivp(
                right_hand_side, (time, case.sample_time), system.z, "DOP853", rtol=1e-10, atol=1e-14, events=events
            )
            system.z, time = part.y[:, -1], part.t[-1]
            if part.status == 1:
                for k in (0, 1):
                    if len(part.t_events[k]):
                        change(k)
        orbit.append(system.bearings)
        at_sample = rate(system.z)[1]
        force.append(np.array([at_sample.get(0, 0.0), at_sample.get(1, 0.0)]))
    return np.array(orbit), np.array(force)
