"""An independent model of touchdown: a journal in its retainer, both bodies in the plane, and their spin.

Coordinates are generalised, q = (x, y, x_h, y_h, theta, phi): journal, housing, angle of the rotor, angle of the race.
Contact forces are Lagrange multipliers of the gap and of the slip, N on the row (n, -n, 0, 0) and T on the row
(t, -t, R_s, -(R_s + c)), so that their work is the same on all bodies; n points from the centre of the clearance to the
journal. SciPy integrates between events. It shares no code with the plant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

X, Y, X_H, Y_H, THETA, PHI = range(6)
FREE, SLIDING, ROLLING = range(3)
SLOW = 1e-6  # m/s, of a rebound that is no longer followed
INSIDE = 1e-13  # of the clearance, by which a flight starts off the circle, so that its end is a crossing


@dataclass(frozen=True)
class TwoBodies:
    """Mass and support of journal and housing, their contact, and inertias of spin, all SI; None does not move."""

    mass: float
    clearance: float
    support_stiffness: float = 0.0
    support_damping: float = 0.0
    force: complex = 0.0  # on the journal (N), a weight for instance
    unbalance: float = 0.0  # kg m
    spin_inertia: float | None = None
    drive_torque: float = 0.0  # N m
    housing_mass: float | None = None
    mount_stiffness: tuple[float, float] = (0.0, 0.0)
    mount_damping: tuple[float, float] = (0.0, 0.0)
    race_inertia: float | None = None
    race_drag: float = 0.0  # N m
    race_viscous_drag: float = 0.0  # N m s
    mu: float = 0.0
    restitution: float = 0.0
    journal_radius: float = 0.025

    def moving(self) -> np.ndarray:
        """Rows of the coordinates that can move."""
        housing, spin, race = (body is not None for body in (self.housing_mass, self.spin_inertia, self.race_inertia))
        return np.flatnonzero([True, True, housing, housing, spin, race])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q): the unbalance couples spin and journal."""
        inertias = [self.housing_mass, self.housing_mass, self.spin_inertia, self.race_inertia]
        M = np.diag([self.mass, self.mass, *(inertia or 1.0 for inertia in inertias)])
        across = self.unbalance * np.array([-math.sin(q[THETA]), math.cos(q[THETA])])
        M[:2, THETA] = M[THETA, :2] = across
        return M

    def mobility(self, q: np.ndarray) -> np.ndarray:
        """M(q)^-1 of moving coordinates, and zero of fixed ones."""
        free = np.ix_(self.moving(), self.moving())
        Minv = np.zeros((6, 6))
        Minv[free] = np.linalg.inv(self.mass_matrix(q)[free])
        return Minv

    def loads(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalised forces without contact, the centrifugal force of the unbalance included."""
        spin = self.unbalance * v[THETA] ** 2
        Q = np.zeros(6)
        Q[X] = self.force.real + spin * math.cos(q[THETA]) - self.support_stiffness * q[X] - self.support_damping * v[X]
        Q[Y] = self.force.imag + spin * math.sin(q[THETA]) - self.support_stiffness * q[Y] - self.support_damping * v[Y]
        Q[X_H] = -self.mount_stiffness[0] * q[X_H] - self.mount_damping[0] * v[X_H]
        Q[Y_H] = -self.mount_stiffness[1] * q[Y_H] - self.mount_damping[1] * v[Y_H]
        Q[THETA] = self.drive_torque
        Q[PHI] = -self.race_drag * math.tanh(v[PHI]) - self.race_viscous_drag * v[PHI]
        return Q

    def gap_row(self, q: np.ndarray) -> np.ndarray:
        """Derivative of the distance |s| of the centres, s = r - r_h."""
        s = q[:2] - q[2:4]
        n = s / np.hypot(*s)
        return np.concatenate([n, -n, [0.0, 0.0]])

    def slip_row(self, q: np.ndarray) -> np.ndarray:
        """Return the row that gives slip from velocities: R_s Omega + t . (v - v_h) - (R_s + c) w."""
        n = self.gap_row(q)[:2]
        t = np.array([-n[1], n[0]])
        return np.concatenate([t, -t, [self.journal_radius, -(self.journal_radius + self.clearance)]])

    def solve(self, q: np.ndarray, v: np.ndarray, mode: int, sign: float) -> tuple[np.ndarray, float, float]:
        """Accelerations, and N (inward) and T (forward) on the journal, in a mode of contact; `sign` of the slip."""
        Minv = self.mobility(q)
        a = Minv @ self.loads(q, v)
        if mode == FREE:
            return a, 0.0, 0.0
        gap, slip = self.gap_row(q), self.slip_row(q)
        across = slip[:4] @ v[:4]
        wanted = -(across**2) / self.clearance - gap @ a
        if mode == SLIDING:
            direction = -gap - self.mu * sign * slip
            N = wanted / (gap @ Minv @ direction)
            return a + N * Minv @ direction, N, -self.mu * sign * N
        rows = np.array([gap, slip])
        N, T = np.linalg.solve(rows @ Minv @ np.array([-gap, slip]).T, [wanted, -slip @ a])
        return a + Minv @ (-gap * N + slip * T), N, T

    def strike(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, float]:
        """Velocities after an impact by Newton's law with Coulomb friction, and its normal impulse (N s)."""
        Minv = self.mobility(q)
        gap, slip = self.gap_row(q), self.slip_row(q)
        rows = np.array([gap, slip])
        response = rows @ Minv @ np.array([-gap, slip]).T
        before = rows @ v
        P, S = np.linalg.solve(response, [-(1.0 + self.restitution) * before[0], -before[1]])
        if abs(S) > self.mu * P:
            ratio = -self.mu * np.sign(before[1])
            P = -(1.0 + self.restitution) * before[0] / (response[0] @ [1.0, ratio])
            S = ratio * P
        return v + Minv @ (-gap * P + slip * S), P

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        """Kinetic energy of all that moves, strain energy, and potential of the force (J)."""
        free = self.moving()
        kinetic = 0.5 * v[free] @ self.mass_matrix(q)[np.ix_(free, free)] @ v[free]
        strain = self.support_stiffness * (q[:2] @ q[:2]) + np.array(self.mount_stiffness) @ q[2:4] ** 2
        return float(kinetic + 0.5 * strain - self.force.real * q[X] - self.force.imag * q[Y])


MOUNTED = TwoBodies(
    mass=10.0,
    clearance=0.25e-3,
    support_stiffness=2e4,
    force=98.1 * np.exp(-0.6j * np.pi),
    housing_mass=4.0,
    mount_stiffness=(4e6, 6e6),
    mount_damping=(400.0, 700.0),
)


@dataclass
class Motion:
    """Result of `follow`: rows at the requested times, and every impact with its time and impulse."""

    q: np.ndarray
    v: np.ndarray
    mode: np.ndarray
    N: np.ndarray
    T: np.ndarray
    impacts: list[tuple[float, float]] = field(default_factory=list)


def follow(
    model: TwoBodies, times: np.ndarray, q: np.ndarray, v: np.ndarray, mode: int = FREE, tolerance: float = 1e-11
) -> Motion:
    """Integrate from (q, v) at time 0 through impacts, sliding, rolling and release, to each of `times` (s)."""
    q, v = np.array(q, dtype=float), np.array(v, dtype=float)
    motion = Motion(*np.zeros((2, len(times), 6)), *np.zeros((3, len(times))))
    sign, now, done = 1.0, 0.0, 0
    if mode == SLIDING:
        sign = float(np.sign(model.slip_row(q) @ v)) or 1.0
    while done < len(times):
        z, now, done, event = _until_event(model, (q, v, mode, sign), now, times, done, motion, tolerance)
        q, v = z[:6], z[6:]
        if event is not None:
            mode, sign, v = _after(model, event, q, v, mode, sign, now, motion)
            if mode == FREE:
                q[:2] -= INSIDE * model.clearance * model.gap_row(q)[:2]
    return motion


def _until_event(model, start, now, times, done, motion, tolerance):
    q, v, mode, sign = start

    def derivative(_: float, z: np.ndarray) -> np.ndarray:
        return np.concatenate([z[6:], model.solve(z[:6], z[6:], mode, sign)[0]])

    events = [_terminal(f) for f in _indicators(model, mode, sign)]
    solution = solve_ivp(
        derivative,
        (now, times[-1]),
        np.concatenate([q, v]),
        method="DOP853",
        rtol=tolerance,
        atol=1e-3 * tolerance,
        max_step=times[-1] / 100,
        events=events,
        dense_output=True,
    )
    end = solution.t[-1]
    while done < len(times) and times[done] <= end:
        z = solution.sol(times[done])
        _, N, T = model.solve(z[:6], z[6:], mode, sign)
        motion.q[done], motion.v[done], motion.mode[done] = z[:6], z[6:], mode
        motion.N[done], motion.T[done] = N, T
        done += 1
    fired = [k for k, t in enumerate(solution.t_events) if len(t)]
    return solution.y[:, -1], end, done, fired[0] if solution.status == 1 else None


def _terminal(indicator: Callable[[float, np.ndarray], float]) -> Callable[[float, np.ndarray], float]:
    indicator.terminal, indicator.direction = True, 1.0  # type: ignore[attr-defined]
    return indicator


def _indicators(model: TwoBodies, mode: int, sign: float) -> list[Callable[[float, np.ndarray], float]]:
    """Events as rising zero crossings: touching; letting go, and the slip's end or static friction's."""
    if mode == FREE:
        return [lambda _, z: np.hypot(*(z[:2] - z[2:4])) - model.clearance]
    letting_go = lambda _, z: -model.solve(z[:6], z[6:], mode, sign)[1]  # noqa: E731
    if mode == SLIDING:
        return [letting_go, lambda _, z: -sign * (model.slip_row(z[:6]) @ z[6:])]

    def overload(_: float, z: np.ndarray) -> float:
        _, N, T = model.solve(z[:6], z[6:], ROLLING, sign)
        return abs(T) - model.mu * N

    return [letting_go, overload]


def _after(model, event, q, v, mode, sign, now, motion):
    """Mode, sign of the slip and velocities after an event."""
    if mode == FREE:
        v, impulse = model.strike(q, v)
        motion.impacts.append((now, impulse))
        if -(model.gap_row(q) @ v) > SLOW:
            return FREE, sign, v
    elif event == 0:
        return FREE, sign, v
    slip = model.slip_row(q) @ v
    if abs(slip) > 1e-9 and not (mode == SLIDING and event == 1):
        return SLIDING, float(np.sign(slip)), v
    _, N, T = model.solve(q, v, ROLLING, sign)
    if mode != ROLLING and abs(T) <= model.mu * N:
        return ROLLING, sign, v
    return SLIDING, -float(np.sign(T)), v
