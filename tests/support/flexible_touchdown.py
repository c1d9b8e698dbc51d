"""An independent model of touchdown: a flexible rotor, its retainers on mounts, their races, and its spin, by SciPy.

Coordinates are generalised, q = (shaft, x and y of the housings, angles of the races, angle of the rotor). Contact
forces are Lagrange multipliers of gap and slip: N on the row (n, -n, 0, 0), T on (t, -t, -(R_s + c), R_s), so that
their work is the same on all bodies; n points from the centre of the clearance to the journal. Impacts obey Newton's
law with Coulomb friction.

    M q'' + (C + R + Omega G) q' + (K - Omega R J) q + p Omega' = f + Omega^2 e,   p = i e
    J Omega' + p . q'' = torque + (J q) . R (q' - Omega J q) + sum T R_s

The matrices of the reduced shaft are data of the plant. Equations, events, impacts, and integration share no code with
it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp

FREE, SLIDING, ROLLING = range(3)
INSIDE = 1e-13  # of the clearance, by which a flight starts off the circle, so that its end is a crossing
STILL = 1e-9  # m/s
# m/s, of a touch that does not rebound, and takes no other site off its circle: they would touch without end
SLOW = 1e-6
LONGEST = 2e-5  # s, of a step, so that a trial does not leave its circle by much


@dataclass(frozen=True)
class Retainer:
    """A contact site: the coordinate of its x, and its parameters (SI); a mass or inertia of 0 does not move."""

    row: int
    clearance: float
    journal_radius: float
    mu: float
    housing_mass: float = 0.0
    mount_stiffness: tuple[float, float] = (0.0, 0.0)
    mount_damping: tuple[float, float] = (0.0, 0.0)
    race_inertia: float = 0.0
    race_drag: float = 0.0  # N m
    race_viscous_drag: float = 0.0  # N m s
    restitution: float = 0.0

    def drag(self, speed: float) -> float:
        """Return the torque that brakes the race (N m)."""
        return self.race_drag * np.tanh(speed) + self.race_viscous_drag * speed


@dataclass(frozen=True, eq=False)
class FlexibleTouchdown:
    """A rotor that falls.

    M, C, R, G, K
        Of the shaft, shape (n, n): R turns with it, G is multiplied by the speed.
    unbalance
        e at the angle 0, as force per Omega^2 (kg m), shape (n,), as x and y in turn.
    force
        The constant force (N), shape (n,).
    sites
        Its retainers.
    spin_inertia
        J (kg m^2) of a free spin, which `torque` (N m) drives; if None, the speed is prescribed and changes by
        `Omega_dot` (rad/s^2).
    seals
        Of each, the rows of x and y, and a function of the speed that returns its K (N/m) and C (N s/m).
    """

    M: np.ndarray
    C: np.ndarray
    R: np.ndarray
    G: np.ndarray
    K: np.ndarray
    unbalance: np.ndarray
    force: np.ndarray
    sites: tuple[Retainer, ...]
    spin_inertia: float | None = None
    Omega_dot: float = 0.0
    torque: float = 0.0
    seals: Sequence[tuple[np.ndarray, Callable[[float], tuple[np.ndarray, np.ndarray]]]] = ()

    @cached_property
    def n(self) -> int:
        return len(self.M)

    @cached_property
    def housings(self) -> dict[int, int]:
        moving = [k for k, site in enumerate(self.sites) if site.housing_mass > 0.0]
        return {k: self.n + 2 * place for place, k in enumerate(moving)}

    @cached_property
    def races(self) -> dict[int, int]:
        turning = [k for k, site in enumerate(self.sites) if site.race_inertia > 0.0]
        return {k: self.n + 2 * len(self.housings) + place for place, k in enumerate(turning)}

    @cached_property
    def size(self) -> int:
        """Number of coordinates; the last is the rotor's angle."""
        return self.n + 2 * len(self.housings) + len(self.races) + 1

    @cached_property
    def constant_mass(self) -> np.ndarray:
        M = np.eye(self.size)
        M[: self.n, : self.n] = self.M
        for k, at in self.housings.items():
            M[at, at] = M[at + 1, at + 1] = self.sites[k].housing_mass
        for k, at in self.races.items():
            M[at, at] = self.sites[k].race_inertia
        M[-1, -1] = self.spin_inertia or 1.0
        return M

    @cached_property
    def constant_mobility(self) -> np.ndarray:
        return np.linalg.inv(self.constant_mass)

    @cached_property
    def J(self) -> np.ndarray:
        """Turns each pair of coordinates by a right angle."""
        return np.kron(np.eye(self.n // 2), [[0.0, -1.0], [1.0, 0.0]])

    def mobility(self, q: np.ndarray) -> np.ndarray:
        """M^-1, with the unbalance that couples shaft and spin; zero for a prescribed angle."""
        if self.spin_inertia is None:
            Minv = self.constant_mobility.copy()
            Minv[-1] = Minv[:, -1] = 0.0
            return Minv
        p = self.J @ self.turned_unbalance(q[-1])
        shaft = self.constant_mobility[: self.n, : self.n]
        s, Minv = shaft @ p, self.constant_mobility.copy()
        alone = 1.0 / (self.spin_inertia - p @ s)
        Minv[: self.n, : self.n] += alone * np.outer(s, s)
        Minv[: self.n, -1] = Minv[-1, : self.n] = -alone * s
        Minv[-1, -1] = alone
        return Minv

    def turned_unbalance(self, theta: float) -> np.ndarray:
        return np.cos(theta) * self.unbalance + np.sin(theta) * (self.J @ self.unbalance)

    def loads(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalised forces without contact."""
        n, Omega, Q = self.n, v[-1], np.zeros(self.size)
        x, u = q[:n], v[:n]
        rotating = self.R @ (u - Omega * (self.J @ x))
        e = self.turned_unbalance(q[-1])
        Q[:n] = self.force + Omega**2 * e - self.K @ x - self.C @ u - Omega * (self.G @ u) - rotating
        for rows, at in self.seals:
            K, C = at(Omega)
            Q[:n] -= rows.T @ (K @ (rows @ x) + C @ (rows @ u))
        if self.spin_inertia is None:
            Q[:n] -= self.Omega_dot * (self.J @ e)
        else:
            Q[-1] = self.torque + (self.J @ x) @ rotating
        for k, at in self.housings.items():
            site = self.sites[k]
            Q[at : at + 2] = -np.array(site.mount_stiffness) * q[at : at + 2]
            Q[at : at + 2] -= np.array(site.mount_damping) * v[at : at + 2]
        for k, at in self.races.items():
            Q[at] = -self.sites[k].drag(v[at])
        return Q

    def apart(self, k: int, q: np.ndarray) -> np.ndarray:
        """x and y of the journal from the centre of its retainer."""
        row, at = self.sites[k].row, self.housings.get(k)
        return q[row : row + 2] - (0.0 if at is None else q[at : at + 2])

    def gap(self, k: int, q: np.ndarray) -> float:
        return float(self.sites[k].clearance - np.hypot(*self.apart(k, q)))

    def rows(self, k: int, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows that give the outward speed and the slip of site k from velocities."""
        site, apart = self.sites[k], self.apart(k, q)
        n = apart / np.hypot(*apart)
        t = np.array([-n[1], n[0]])
        outward, slip = np.zeros((2, self.size))
        outward[site.row : site.row + 2], slip[site.row : site.row + 2] = n, t
        if k in self.housings:
            at = self.housings[k]
            outward[at : at + 2], slip[at : at + 2] = -n, -t
        if k in self.races:
            slip[self.races[k]] = -(site.journal_radius + site.clearance)
        slip[-1] = site.journal_radius
        return outward, slip

    def across(self, k: int, q: np.ndarray, v: np.ndarray) -> float:
        """Speed of the journal along its retainer's circle."""
        apart, moved = self.apart(k, q), self.apart(k, v)
        return float(apart[0] * moved[1] - apart[1] * moved[0]) / float(np.hypot(*apart))

    def forces(self, q, v, contact) -> tuple[np.ndarray, dict[int, tuple[float, float]]]:
        """Accelerations, and N and T of the closed sites: `contact` has the mode and the sign of slip of each."""
        Minv = self.mobility(q)
        a = Minv @ self.loads(q, v)
        if self.spin_inertia is None:
            a[-1] = self.Omega_dot
        wanted = {k: -(self.across(k, q, v) ** 2) / self.sites[k].clearance for k in contact}
        return self._constrained(q, a, contact, wanted, Minv)

    def impulses(self, q, v, contact, rebounds=False) -> tuple[np.ndarray, dict[int, tuple[float, float]]]:
        """Velocities after the sites of `contact` have lost or reversed their outward speed; impulses along n and t."""
        wanted = {k: -rebounds * self.sites[k].restitution * (self.rows(k, q)[0] @ v) for k in contact}
        return self._constrained(q, v, contact, wanted, self.mobility(q))

    def _constrained(self, q, a, contact, wanted, Minv):
        if not contact:
            return a, {}
        A, b, D, place = [], [], [], []
        for k, (mode, sign) in contact.items():
            outward, slip = self.rows(k, q)
            A.append(outward)
            b.append(wanted[k] - outward @ a)
            if mode == ROLLING:
                D += [-outward, slip]
                A.append(slip)
                b.append(-slip @ a)
                place += [(k, 0), (k, 1)]
            else:
                D.append(-outward - self.sites[k].mu * sign * slip)
                place.append((k, 0))
        D = np.array(D).T
        x = np.linalg.solve(np.array(A) @ Minv @ D, b)
        values = dict(zip(place, x, strict=True))
        result = {}
        for k, (mode, sign) in contact.items():
            N = values[k, 0]
            result[k] = (N, values[k, 1] if mode == ROLLING else -self.sites[k].mu * sign * N)
        return a + Minv @ (D @ x), result

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        """Kinetic energy without that of a prescribed spin, and strain energy (J)."""
        n, M = self.n, self.constant_mass.copy()
        if self.spin_inertia is None:
            M[-1, -1] = 0.0
        else:
            M[:n, -1] = M[-1, :n] = self.J @ self.turned_unbalance(q[-1])
        strain = q[:n] @ self.K @ q[:n]
        for k, at in self.housings.items():
            strain += np.array(self.sites[k].mount_stiffness) @ q[at : at + 2] ** 2
        return float(0.5 * (v @ M @ v + strain))


@dataclass
class Fall:
    """What `fall` found: coordinates and velocities at the requested times, and sums over each site."""

    q: np.ndarray
    v: np.ndarray
    mode: np.ndarray  # of contact, shape (times, sites), as the forces N and T (N)
    N: np.ndarray
    T: np.ndarray
    impulse: np.ndarray  # (N s) of N and of impacts until each time, shape (times, sites)
    heat: np.ndarray  # (J) of friction, impacts and the drag of races until each time
    impacts: list[tuple[float, int]] = field(default_factory=list)  # time (s) and site
    modes: set[int] = field(default_factory=set)


def fall(
    model: FlexibleTouchdown,
    times: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    tolerance: float = 1e-10,
    longest: float = LONGEST,
) -> Fall:
    """Integrate from rest or motion without contact to each of `times` (s), through every impact and release."""
    count, sites = len(times), len(model.sites)
    found = Fall(*np.zeros((2, count, model.size)), *np.zeros((4, count, sites)), np.zeros(count))
    sums, contact, now, done = np.zeros(sites + 1), {}, 0.0, 0
    z = np.concatenate([q, v, sums])
    while done < count:
        solution, fired = _until_event(model, contact, now, times[-1], z, tolerance, longest)
        while done < count and times[done] <= solution.t[-1]:
            at = solution.sol(times[done])
            found.q[done], found.v[done] = np.split(at[: 2 * model.size], 2)
            found.impulse[done], found.heat[done] = at[2 * model.size : -1], at[-1]
            for k, force in model.forces(found.q[done], found.v[done], contact)[1].items():
                found.mode[done, k], found.N[done, k], found.T[done, k] = contact[k][0], *force
            done += 1
        now, z = solution.t[-1], solution.y[:, -1].copy()
        if fired is not None:
            contact = _after(model, contact, fired, z, now, found)
            found.modes |= {mode for mode, _ in contact.values()}
    return found


def _until_event(model, contact, now, end, z, tolerance, longest):
    size = model.size

    def derivative(_: float, z: np.ndarray) -> np.ndarray:
        q, v = z[:size], z[size : 2 * size]
        a, forces = model.forces(q, v, contact)
        rates = np.zeros(len(model.sites) + 1)
        for k, (N, T) in forces.items():
            rates[k] = N
            rates[-1] -= T * (model.rows(k, q)[1] @ v)
        for k, at in model.races.items():
            rates[-1] += model.sites[k].drag(v[at]) * v[at]
        return np.concatenate([v, a, rates])

    watched = [(k, what) for k in range(len(model.sites)) for what in _watched(model, contact, k)]
    events = [_falling(model, contact, k, what) for k, what in watched]
    absolute = tolerance * np.concatenate([np.full(size, 1e-3), np.full(size, 1.0), np.full(len(model.sites) + 1, 1.0)])
    solution = solve_ivp(
        derivative,
        (now, end),
        z,
        method="DOP853",
        rtol=tolerance,
        atol=absolute,
        max_step=longest,
        events=events,
        dense_output=True,
    )
    fired = [watched[k] for k, t in enumerate(solution.t_events) if len(t)]
    return solution, fired[0] if solution.status == 1 else None


def _watched(model, contact, k):
    if k not in contact:
        return ["gap"]
    if contact[k][0] == SLIDING:
        return ["pull", "slip"] if model.sites[k].mu > 0.0 else ["pull"]
    return ["pull", "overload"]


def _falling(model, contact, k, what):
    def indicator(_: float, z: np.ndarray) -> float:
        q, v = z[: model.size], z[model.size : 2 * model.size]
        if what == "gap":
            return model.gap(k, q)
        if what == "slip":
            return contact[k][1] * float(model.rows(k, q)[1] @ v)
        N, T = model.forces(q, v, contact)[1][k]
        return N if what == "pull" else model.sites[k].mu * N - abs(T)

    indicator.terminal, indicator.direction = True, -1.0
    return indicator


def _after(model, contact, fired, z, now, found):
    """The contact after an event, with the impulses of an impact added to z."""
    size, (k, what) = model.size, fired
    q, v = z[:size], z[size : 2 * size]  # views
    contact = dict(contact)
    if what == "gap":
        for other, site in enumerate(model.sites):
            at_once = other == k or model.gap(other, q) < INSIDE * site.clearance
            if other not in contact and at_once and model.rows(other, q)[0] @ v > (0.0 if other == k else SLOW):
                contact[other] = (SLIDING, _sign(model, other, q, v))
        slow = model.rows(k, q)[0] @ v < SLOW
        v_new, impulses = model.impulses(q, v, contact) if slow else _strike(model, contact, q, v)
        found.impacts.append((now, k))
        mean = 0.5 * (v + v_new)
        for other, (P, S) in impulses.items():
            z[2 * size + other] += P
            outward, slip = model.rows(other, q)
            z[-1] += P * (outward @ mean) - S * (slip @ mean)
        v[:] = v_new
        contact = {k: slides for k, slides in contact.items() if model.rows(k, q)[0] @ v > -SLOW}
    elif what == "pull":
        del contact[k]
    elif what == "slip":
        contact[k] = (ROLLING, 0.0)
    else:
        contact[k] = (SLIDING, -float(np.sign(model.forces(q, v, contact)[1][k][1])))
    return _settle(model, contact, q, v)


def _strike(model, contact, q, v):
    """Impulses at all closed sites, of which none pulls and no friction turns its slip around."""
    while True:
        v_new, impulses = model.impulses(q, v, contact, rebounds=True)
        pulling = min(impulses, key=lambda k: impulses[k][0])
        if impulses[pulling][0] < 0.0:
            del contact[pulling]
            continue
        turned = [k for k, (mode, sign) in contact.items() if mode == SLIDING and model.sites[k].mu > 0.0]
        turned = [k for k in turned if contact[k][1] * (model.rows(k, q)[1] @ v_new) < -STILL]
        if not turned:
            return v_new, impulses
        contact[turned[0]] = (ROLLING, 0.0)


def _settle(model, contact, q, v):
    """Release sites that pull, and put those without contact a hair inside their circles."""
    while contact:
        forces = model.forces(q, v, contact)[1]
        pulling = min(forces, key=lambda k: forces[k][0])
        if forces[pulling][0] > 0.0:
            break
        del contact[pulling]
    for k, site in enumerate(model.sites):
        least = INSIDE * site.clearance
        if k not in contact and model.gap(k, q) < least:
            outward = model.rows(k, q)[0]
            q[site.row : site.row + 2] -= (least - model.gap(k, q)) * outward[site.row : site.row + 2]
    for k, (mode, _) in list(contact.items()):
        if mode == ROLLING:
            N, T = model.forces(q, v, contact)[1][k]
            if abs(T) > model.sites[k].mu * N:
                contact[k] = (SLIDING, -float(np.sign(T)))
    return contact


def _sign(model, k, q, v):
    return float(np.sign(model.rows(k, q)[1] @ v)) or 1.0
