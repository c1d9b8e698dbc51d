"""Sustained contact without friction: closed forms, the constraint, and an independent integration."""

import math

import numpy as np
import pytest
from rotor_cases import (
    BEARINGS,
    CLEARANCE,
    H,
    OnePlane,
    bearing_positions,
    both,
    masters,
    place,
    plant,
    rigid_rotor,
    run,
)
from scipy.integrate import solve_ivp

from rotor_analysis.rotor_file import load_rotor
from rotor_contact.enumerations import NODAL

ROTOR = load_rotor()
RING = 0.05  # clearance in the closed-form cases (m)
NORMAL = ["rb1.f_n", "rb2.f_n"]
GAPS = ["rb1.gap", "rb2.gap"]


@pytest.mark.parametrize("omega", [30.0, -30.0])
def test_rotor_whirling_round_the_ring_is_pressed_on_by_m_c_omega_squared(omega):
    mass = 20.0
    x = plant(both("rb.clearance", RING), rigid_rotor(mass))
    start = np.full(2, RING * np.exp(0.3j))
    place(x, start, 1j * omega * start, modes=(1, 1))
    record = run(x, 400, [*NORMAL, "rb1.whirl_speed", "rb1.f_t", "energy.dissipated", "contact_state"])
    np.testing.assert_allclose(record[:, :2], mass / 2 * RING * omega**2, rtol=1e-6)
    np.testing.assert_allclose(record[:, 2], omega, rtol=1e-7)
    np.testing.assert_array_equal(record[:, 3:5], 0.0)
    np.testing.assert_array_equal(record[:, 5], 3)
    np.testing.assert_allclose(bearing_positions(x), start * np.exp(1j * omega * 400 * H), rtol=1e-6)


def test_ring_carries_what_the_springs_leave_over():
    mass, omega, k_b = 20.0, 30.0, 3000.0
    x = plant(both("rb.clearance", RING) | both("mb.k_b", k_b), rigid_rotor(mass))
    start = np.full(2, RING + 0j)
    place(x, start, 1j * omega * start, modes=(1, 1))
    record = run(x, 100, NORMAL)
    np.testing.assert_allclose(record, mass / 2 * RING * omega**2 - k_b * RING, rtol=1e-6)


def test_retainer_centre_moves_the_whole_orbit():
    omega, offset = 30.0, 0.01 - 0.02j
    centre = both("rb.offset_x", offset.real) | both("rb.offset_y", offset.imag)
    x = plant(both("rb.clearance", RING) | centre, rigid_rotor())
    place(x, np.full(2, offset + RING), np.full(2, 1j * omega * RING), modes=(1, 1))
    record = run(x, 200, NORMAL)
    np.testing.assert_allclose(record, 10.0 * RING * omega**2, rtol=1e-6)
    np.testing.assert_allclose(bearing_positions(x), offset + RING * np.exp(1j * omega * 200 * H), rtol=1e-6)


def test_rotor_leaves_the_ring_where_the_normal_force_vanishes():
    """From the bottom with v0^2 = 3.5 g c: N = m (v^2/c + g cos phi) = 0 at cos phi = -1/2, 120 degrees."""
    g = 9.81
    v0 = math.sqrt(3.5 * g * RING)
    x = plant(both("rb.clearance", RING) | {"base.a_y": g}, rigid_rotor(20.0))
    place(x, np.full(2, -1j * RING), np.full(2, v0 + 0j), modes=(1, 1))
    h = 1e-4
    energy = 0.5 * 20.0 * v0**2 - 20.0 * g * RING
    released = None
    for n in range(2000):
        x.step(n * h, h)
        r, v = (part[0] for part in masters(x))
        if x["rb1.mode"] == 0:
            released = r, v
            break
        assert x["rb1.f_n"] >= 0.0
        phi = math.atan2(r.real, -r.imag)
        speed2 = v0**2 - 2 * g * RING * (1 - math.cos(phi))
        assert x["rb1.f_n"] == pytest.approx(10.0 * (speed2 / RING + g * math.cos(phi)), rel=1e-6, abs=1e-4)
    assert released is not None
    r, v = released
    assert 0.5 * 20.0 * abs(v) ** 2 + 20.0 * g * r.imag == pytest.approx(energy, rel=1e-7)
    angle = math.degrees(math.atan2(r.real, -r.imag))
    assert 120.0 - 1e-3 <= angle <= 120.0 + math.degrees(abs(v) / RING * h)


def rubbing(**values):
    """The rig trapped in contact: strong unbalance above the second critical speed, newton law, some friction."""
    given = BEARINGS | both("rb.mu", 0.1) | {"Omega": 120.0, "d1.u": 0.08, "d3.u": 0.05}
    return plant(given | {name.replace("__", "."): value for name, value in values.items()})


def constraint_over(duration):
    x = rubbing()
    record = run(x, round(duration / H), [*NORMAL, *GAPS, "rb1.mode", "rb2.mode", "mb1.x", "mb1.y", "mb2.x", "mb2.y"])
    closed = record[:, 4:6] > 0
    radius = np.hypot(record[:, 6::2], record[:, 7::2])
    return record, closed, radius


def check_constraint(record, closed, radius):
    assert np.mean(closed) > 0.3
    assert np.all(radius < CLEARANCE + 1e-9)
    assert np.all(np.abs(radius - CLEARANCE)[closed] < 1e-9)
    assert np.all(record[:, :2] >= -1e-6)
    assert np.all(record[:, 2:4] >= -1e-12)
    assert np.all(record[:, :2][~closed] == 0.0)


def test_journals_stay_within_the_ring_and_are_never_pulled():
    check_constraint(*constraint_over(3.0))


@pytest.mark.slow
def test_constraint_does_not_drift_in_a_minute_of_sliding():
    record, closed, radius = constraint_over(60.0)
    check_constraint(record, closed, radius)
    late = slice(-4000, None)
    assert np.all(np.abs(radius - CLEARANCE)[late][closed[late]] < 1e-12)


class Reference:
    """The rig on continuous bearings with the thesis's KKT system (4.24), by pseudo-inverse, and scipy's events.

    Real coordinates are all x, then all y. Frictionless, nodal impacts.
    """

    def __init__(self, Omega, u):
        self.model = OnePlane.of(ROTOR, 1e6, 5000.0)
        self.Omega, self.rotating = Omega, Omega**2 * self.model.unbalance([u, 0, 0, 0])
        n = self.n = len(self.model.M)
        self.M = np.kron(np.eye(2), self.model.M)
        self.active = [False, False]
        self.normal = [0.0, 0.0]
        self.J = np.zeros((2, 2 * n))

    def derivative(self, t, z):
        n = self.n
        q, v = z[: 2 * n], z[2 * n :]
        r, w = q[:n] + 1j * q[n:], v[:n] + 1j * v[n:]
        m = self.model
        force = self.rotating * np.exp(1j * self.Omega * t) - m.K @ r - m.C @ w + 1j * self.Omega * (m.G @ w)
        sites = [k for k in range(2) if self.active[k]]
        J, D = np.zeros((len(sites), 2 * n)), np.zeros(len(sites))
        for row, k in enumerate(sites):
            j = m.bearings[k]
            J[row, j], J[row, n + j] = 2 * q[j], 2 * q[n + j]
            D[row] = 2 * v[j] ** 2 + 2 * v[n + j] ** 2
        system = np.block([[self.M, J.T], [J, np.zeros((len(sites), len(sites)))]])
        scale = 1.0 / np.sqrt(np.diag(self.M).mean())
        weights = np.concatenate([np.ones(2 * n), np.full(len(sites), 1.0 / (2 * CLEARANCE))]) * scale
        right = np.concatenate([force.real, force.imag, -D]) * weights
        answer = weights * (np.linalg.pinv(weights[:, None] * system * weights) @ right)
        self.normal = [0.0, 0.0]
        for row, k in enumerate(sites):
            self.normal[k] = 2 * CLEARANCE * answer[2 * n + row]
        return np.concatenate([v, answer[: 2 * n]])

    def radius(self, k, z):
        j = self.model.bearings[k]
        return math.hypot(z[j], z[self.n + j])

    def run(self, z, duration, sample):
        """Times and normal forces at multiples of `sample`, and event times as (t, site, closed afterwards)."""

        def gap(k):
            def event(t, y):
                return -1.0 if self.active[k] else self.radius(k, y) / CLEARANCE - 1.0

            event.terminal, event.direction = True, 1.0
            return event

        def pull(k):
            def event(t, y):
                if not self.active[k]:
                    return 1.0
                self.derivative(t, y)
                return self.normal[k]

            event.terminal, event.direction = True, -1.0
            return event

        times = np.arange(1, round(duration / sample) + 1) * sample
        forces, positions, events = np.zeros((len(times), 2)), np.zeros((len(times), 2)), []
        t = 0.0
        while t < times[-1] - 1e-12:
            solution = solve_ivp(
                self.derivative,
                (t, times[-1]),
                z,
                method="DOP853",
                rtol=1e-9,
                atol=1e-13,
                events=[gap(0), gap(1), pull(0), pull(1)],
                dense_output=True,
                max_step=2e-4,
            )
            inside = (times > t) & (times <= solution.t[-1])
            for i in np.flatnonzero(inside):
                y = solution.sol(times[i])
                self.derivative(times[i], y)
                forces[i] = self.normal
                positions[i] = [self.radius(k, y) for k in range(2)]
            t, z = solution.t[-1], solution.y[:, -1].copy()
            for kind, found in enumerate(solution.t_events):
                if len(found):
                    k, closes = kind % 2, kind < 2
                    self.active[k] = closes
                    events.append((t, k, closes))
                    if closes:
                        j, n = self.model.bearings[k], self.n
                        normal = np.array([z[j], z[n + j]]) / self.radius(k, z)
                        rows = [2 * n + j, 3 * n + j]
                        z[rows] -= normal * (normal @ z[rows])
            self.derivative(t, z)
            while min(self.normal) < 0.0:  # a wall that would have to pull is not there
                k = int(np.argmin(self.normal))
                self.active[k] = False
                events.append((t, k, False))
                self.derivative(t, z)
            assert len(events) < 100
        return times, forces, positions, events


def test_contact_forces_of_fig4_9_are_those_of_an_independent_kkt_system():
    """260 rad/s, D1 0.5 -> 25.5 g m from the settled orbit, nodal impacts, continuous bearings."""
    Omega, sample, duration = 260.0, 1e-4, 0.08
    reference = Reference(Omega, 25.5e-3)
    orbit = reference.model.orbit(Omega, [0.5e-3, 0, 0, 0])
    velocity = 1j * Omega * orbit
    start = np.concatenate([orbit.real, orbit.imag, velocity.real, velocity.imag])
    times, forces, radii, events = reference.run(start, duration, sample)

    values = BEARINGS | {"Omega": Omega, "d1.u": 25.5e-3, "contact.impact_law": NODAL, "solver.max_substep": 1e-5}
    x = place(plant(values), orbit, velocity)
    record = run(x, len(times), [*NORMAL, *GAPS], h=sample)

    assert {k for _, k, closes in events if closes} == {0, 1}
    assert len(events) >= 6
    peak = forces.max(axis=0)
    assert np.all(peak > 500.0)
    near = np.zeros(len(times), dtype=bool)  # samples next to an event: the force jumps there
    for t, _, _ in events:
        near |= np.abs(times - t) < 2e-6
    assert np.mean(near) < 0.2
    np.testing.assert_allclose(record[~near, :2], forces[~near], atol=1e-4 * peak.max())
    np.testing.assert_allclose(CLEARANCE - record[:, 2:], radii, atol=1e-5 * CLEARANCE)
