"""ROLAC: optimum, rate, sign, switching."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rolac_controller.controller import BEARING_K_I
from rolac_controller.rolac import adapt
from rolac_controller.table import pack

UNBALANCE_RESPONSE = 1e-4 * np.exp(1j * np.linspace(0.0, 5.0, 8)) * np.linspace(0.5, 1.5, 8)
SAMPLES = 40  # per revolution, 100 Hz


@pytest.fixture
def plant(bench, receptance, speed_of):
    """Makes a controller on the plant q = Re[(Q_0 + R U) exp(j theta)] and the function that runs it."""

    def make(table_of, **parameters):
        b = bench(pack([1.0], [table_of]), Omega=speed_of(SAMPLES), **parameters)

        def run(samples):
            for _ in range(samples):
                q = UNBALANCE_RESPONSE + receptance @ b.forces()
                b.sense((q * np.exp(1j * b.theta)).real)
                b.sample()
            return b.forces()

        return b, run

    return make


@pytest.fixture
def optimum(receptance):
    """Least-squares optimum of the forces, by a solver that knows nothing of H."""
    return np.linalg.lstsq(receptance, -UNBALANCE_RESPONSE, rcond=None)[0]


def test_forces_reach_the_least_squares_optimum(plant, receptance, optimum):
    b, run = plant(receptance)
    run(SAMPLES + 5)
    before = np.sum(np.abs(b.components()) ** 2)
    b["rolac_enable"] = 1.0
    forces = run(12000)
    np.testing.assert_allclose(forces, optimum, rtol=1e-6)
    least = np.sum(np.abs(UNBALANCE_RESPONSE + receptance @ optimum) ** 2)
    assert np.sum(np.abs(b.components()) ** 2) == pytest.approx(least, rel=1e-6)
    assert least < 0.9 * before


def test_law_converges_at_exactly_alpha_when_q_follows_at_once(receptance, optimum):
    table, h, alpha = pack([1.0], [receptance]), 250e-6, 7.0
    force, q = np.zeros(8), np.zeros(16)
    for n in range(1, 2001):
        response = UNBALANCE_RESPONSE + receptance @ (force[::2] + 1j * force[1::2])
        q[::2], q[1::2] = response.real, response.imag
        adapt(table, 100.0, alpha * h, q, force)
        if n % 500 == 0:
            expected = optimum * (1.0 - (1.0 - alpha * h) ** n)
            np.testing.assert_allclose(force[::2] + 1j * force[1::2], expected, rtol=1e-9)


def test_rate_over_the_last_revolution_solves_its_characteristic_equation(plant, receptance, optimum):
    """With Q averaged over a period T the error decays with s = -alpha (1 - exp(-s T))/(s T)."""
    period, alpha = SAMPLES * 250e-6, 7.0
    b, run = plant(receptance)
    run(SAMPLES + 5)
    b["rolac_enable"] = 1.0
    early = np.linalg.norm(run(10 * SAMPLES) - optimum)
    late = np.linalg.norm(run(20 * SAMPLES) - optimum)
    s = -alpha
    for _ in range(100):
        s = -alpha * (1.0 - math.exp(-s * period)) / (s * period)
    assert math.log(late / early) / (20 * period) == pytest.approx(s, rel=0.01)
    assert s == pytest.approx(-alpha, rel=0.05)


def test_wrong_sign_of_h_diverges(plant, receptance):
    b, run = plant(-receptance)
    b["rolac_enable"] = 1.0
    early, late = np.linalg.norm(run(1000)), np.linalg.norm(run(1000))
    assert late > 4.0 * early > 0.0


def test_force_turns_with_the_rotor_on_top_of_the_pid(plant, receptance):
    """I = I_pid + (Re[U] cos(theta) - Im[U] sin(theta))/K_i."""
    b, run = plant(receptance, mb1__k_b_x=0.0, mb1__k_s_x=0.0, mb1__c_b_x=0.0)
    b["rolac_enable"] = 1.0
    for _ in range(300):
        theta = b.theta
        u = run(1)[0]
        expected = (u.real * math.cos(theta) - u.imag * math.sin(theta)) / BEARING_K_I
        assert b["mb1.i_x"] == pytest.approx(expected, rel=1e-10, abs=1e-13)
    assert abs(u) > 1.0


def test_off_means_no_force_and_on_starts_from_none(plant, receptance):
    b, run = plant(receptance)
    assert not run(200).any()
    b["rolac_enable"] = 1.0
    first = np.abs(run(1)).max()
    grown = np.abs(run(400)).max()
    assert b["rolac_active"] == 1.0
    assert grown > 50.0 * first
    b["rolac_enable"] = 0.0
    assert not run(1).any()
    assert b["rolac_active"] == 0.0
    run(60)
    b["rolac_enable"] = 1.0
    assert 0.0 < np.abs(run(1)).max() < 2.0 * first


def test_no_force_before_the_first_full_revolution(plant, receptance):
    b, run = plant(receptance)
    b["rolac_enable"] = 1.0
    assert not run(SAMPLES).any()
    assert b["rolac_active"] == 0.0
    assert run(1).all()


@pytest.mark.parametrize("frequency", [0.0, 4.9])
def test_below_5_hz_the_pid_works_alone(bench, receptance, frequency):
    with_rolac = bench(pack([1.0], [receptance]), Omega=2.0 * math.pi * frequency)
    alone = bench(Omega=2.0 * math.pi * frequency)
    with_rolac["rolac_enable"] = 1.0
    for b in (with_rolac, alone):
        b.follow(lambda theta: np.full(8, 1e-4 * math.sin(theta + 1.0)), 1500)
    assert with_rolac["rolac_active"] == 0.0
    assert with_rolac["mb1.i_x"] == alone["mb1.i_x"] != 0.0


def test_adaptation_rate_zero_holds_the_force(plant, receptance):
    b, run = plant(receptance)
    b["rolac_enable"] = 1.0
    run(500)
    b["rolac.alpha"] = 0.0
    held = run(1)
    np.testing.assert_array_equal(run(100), held)
    assert np.abs(held).min() > 0.0


def test_currents_stay_within_their_limits_with_rolac(plant, receptance):
    b, run = plant(-receptance)
    b["rolac_enable"] = 1.0
    currents = []
    for _ in range(3000):
        run(1)
        currents.append(b["mb1.i_x"])
    assert min(currents) == -5.57
    assert max(currents) == 4.43
