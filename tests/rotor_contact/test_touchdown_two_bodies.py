"""Contact of two bodies with rotating races and free spin, against an independent model and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from flexible_touchdown import FREE, SLIDING
from rotor_cases import CLEARANCE, UNWATCHED, both, plant, rigid_rotor, run, state
from touchdown_cases import follow_plant, plant_of
from two_bodies import MOUNTED, PHI, THETA, X_H, TwoBodies, X, Y, follow

RUBBING = replace(MOUNTED, mu=0.1)
FIXED = replace(RUBBING, housing_mass=None)
RACE = {"race_inertia": 1e-4, "race_drag": 0.01, "race_viscous_drag": 1e-4}
SPIN = {"spin_inertia": 5e-3, "unbalance": 2e-3}
CASES = {
    "mounted": RUBBING,
    "mounted, without friction": MOUNTED,
    "race": replace(FIXED, **RACE),
    "free spin": replace(FIXED, spin_inertia=5e-3, unbalance=5e-3),
    "all, rolling": replace(MOUNTED, **RACE, **SPIN, mu=0.3, drive_torque=1.0),
}
START = np.array([0.05, 0.0, -0.02, 0.01, 200.0, 0.0])
SPAN, POINTS = 0.04, 40
TIMES = SPAN / POINTS * np.arange(1, POINTS + 1)
INTEGRATED = {"solver.exact_motion": 0.0}


def starting(model):
    """Return initial velocities, without that of a fixed housing."""
    return START * [1, 1, model.housing_mass is not None, model.housing_mass is not None, 1, 1]


@pytest.mark.parametrize("case", CASES)
def test_bodies_move_as_integrated_independently(case):
    model = CASES[case]
    q, v = np.zeros(6), starting(model)
    rotor = plant_of(model, q, v, **INTEGRATED)
    ours, expected = follow_plant(rotor, TIMES), follow(model, TIMES, q, v)
    assert {FREE, SLIDING} <= set(expected.mode)
    np.testing.assert_array_equal(ours.mode, expected.mode)
    np.testing.assert_allclose(ours.q[:, :4], expected.q[:, :4], atol=1e-11)
    np.testing.assert_allclose(ours.v[:, THETA], expected.v[:, THETA], rtol=1e-9)
    np.testing.assert_allclose(ours.v[:, PHI], expected.v[:, PHI], atol=1e-6)
    np.testing.assert_allclose(ours.N, expected.N, atol=1e-5)
    np.testing.assert_allclose(ours.T, expected.T, atol=1e-5)
    assert abs(rotor["energy.balance"]) < 1e-9 * (rotor["energy.kinetic"] + rotor["energy.dissipated"])


@pytest.mark.parametrize("case", CASES)
def test_step_ladder_moves_bodies_as_integrated_independently(case):
    """In steps short enough that most come after the 32 that it waits for."""
    model, times = CASES[case], SPAN / 400 * np.arange(1, 401)
    q, v = np.zeros(6), starting(model)
    ours, expected = follow_plant(plant_of(model, q, v), times), follow(model, times, q, v)
    np.testing.assert_array_equal(ours.mode, expected.mode)
    np.testing.assert_allclose(ours.q[:, :4], expected.q[:, :4], atol=1e-5 * model.clearance)
    np.testing.assert_allclose(ours.v[:, THETA], expected.v[:, THETA], rtol=1e-6)
    np.testing.assert_allclose(ours.v[:, PHI], expected.v[:, PHI], atol=1e-3)
    largest = np.max(expected.N)
    np.testing.assert_allclose(ours.N, expected.N, atol=1e-5 * largest)
    np.testing.assert_allclose(ours.T, expected.T, atol=1e-5 * largest)


def test_bouncing_bodies_move_as_integrated_independently():
    """The last bounces, which each model truncates differently, leave 1e-8 m."""
    model = replace(CASES["all, rolling"], restitution=0.4)
    q, v = np.zeros(6), starting(model)
    expected = follow(model, TIMES, q, v)
    assert len(expected.impacts) > 20
    ours = follow_plant(plant_of(model, q, v, **INTEGRATED), TIMES)
    np.testing.assert_allclose(ours.q[:, :4], expected.q[:, :4], atol=1e-7)


@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
def test_impact_conserves_momentum_of_journal_and_free_housing(e):
    m, m_h, speed, angle = 10.0, 4.0, 0.2, 0.7
    model = TwoBodies(mass=m, clearance=1e-3, housing_mass=m_h, restitution=e)
    n = np.array([np.cos(angle), np.sin(angle)])
    rotor = plant_of(model, np.zeros(6), np.concatenate([speed * n, np.zeros(4)]))
    after = 2e-3  # the gap closes at 5 ms
    moved = follow_plant(rotor, np.array([5e-3 + after])).q[0]
    common = m * speed / (m + m_h)
    journal, housing = common - e * m_h * speed / (m + m_h), common + e * m * speed / (m + m_h)
    np.testing.assert_allclose(moved[[X, Y]], n * (1e-3 + journal * after), atol=1e-12)
    np.testing.assert_allclose(moved[[X_H, X_H + 1]], n * housing * after, atol=1e-12)
    assert rotor["rb1.impulse"] == pytest.approx((1 + e) * speed / (1 / m + 1 / m_h), rel=1e-9)
    assert rotor["energy.impact"] == pytest.approx((1 - e**2) * speed**2 / (1 / m + 1 / m_h), abs=1e-9)


@pytest.mark.parametrize("housing", [{}, {"rb1.housing_mass": 3.0, "rb1.mount_stiffness_x": 1e6}])
def test_an_impact_that_ends_within_a_substep_is_not_missed(housing):
    """A force turns the journal within a substep; at both ends of it there is a gap."""
    outward, turned_after, gap = 0.05, 15e-6, 1e-7
    rotor = plant(both("eb.enabled", 0) | {"rb2.enabled": 0, "Omega": 1.0} | housing | UNWATCHED, rigid_rotor(20.0))
    z, n = state(rotor), 6 if housing else 4
    z[[0, 2]], z[[n, n + 2]] = CLEARANCE - gap, outward
    for bearing in ("mb1", "mb2"):
        rotor[f"{bearing}.f_x"] = -10.0 * outward / turned_after
    run(rotor, 1, h=62.5e-6)
    assert rotor["rb1.impulse"] > 0.1 * 10.0 * outward
