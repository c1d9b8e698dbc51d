"""The levitated rotor with contact, integrated as a whole: the reference for the co-simulation.

Between samples the system is that of `bath_thesis.studies.monolithic`, and

    M r'' + .. = .. - B n N
    closed site k: Re(conj(n_k) r_k'') = -|r_k'|^2 / c with n_k = r_k / |r_k|, or N_k = 0 if it is open
"""

import numpy as np
from scipy.integrate import solve_ivp

from bath_thesis.studies.monolithic import BEARINGS, Levitation, MonolithicSystem

CLEARANCE = 0.75e-3


def orbit_with_contact(case: Levitation, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Complex displacement at MB1 and MB2 (m), and normal forces (N), at each sample, from rest.

    Frictionless contact as a constraint with the nodal impact law, integrated to tight tolerances with located events.
    """
    system = MonolithicSystem(case)
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
