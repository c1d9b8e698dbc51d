"""Sustained contact without friction: closed forms, the constraint, and an independent integration."""

import math

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, bearing_positions, both, masters, place, plant, rigid_rotor, run

RING = 0.05  # clearance in the closed-form cases (m)
NORMAL = ["rb1.f_n", "rb2.f_n"]
GAPS = ["rb1.gap", "rb2.gap"]


@pytest.mark.parametrize(("k_b", "centre"), [(0.0, 0j), (3000.0, 0j), (0.0, 0.01 - 0.02j)])
@pytest.mark.parametrize(("omega", "spin"), [(30.0, 0.0), (-30.0, 300.0)])
def test_rotor_whirling_round_the_ring_is_pressed_on_by_m_c_omega_squared(omega, spin, k_b, centre):
    """Less the spring forces of the bearings; without friction the spin has no effect."""
    mass = 20.0
    values = both("rb.clearance", RING) | both("mb.k_b", k_b) | {"Omega": spin}
    values |= both("rb.offset_x", centre.real) | both("rb.offset_y", centre.imag)
    x = plant(values, rigid_rotor(mass))
    start = np.full(2, RING * np.exp(0.3j))
    place(x, centre + start, 1j * omega * start, modes=(1, 1))
    record = run(x, 400, [*NORMAL, "rb1.whirl_speed", "rb1.f_t", "energy.dissipated", "contact_state"])
    np.testing.assert_allclose(record[:, :2], mass / 2 * RING * omega**2 - k_b * RING, rtol=1e-6)
    np.testing.assert_allclose(record[:, 2], omega, rtol=1e-7)
    np.testing.assert_array_equal(record[:, 3:5], 0.0)
    np.testing.assert_array_equal(record[:, 5], 3)
    np.testing.assert_allclose(bearing_positions(x), centre + start * np.exp(1j * omega * 400 * H), rtol=1e-6)


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
    settings = BEARINGS | both("rb.mu", 0.1) | {"Omega": 120.0, "d1.u": 0.08, "d3.u": 0.05}
    return plant(settings | {name.replace("__", "."): value for name, value in values.items()})


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
