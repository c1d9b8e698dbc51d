"""ROLAC: optimum, rate, sign, switching, limit, harmonics, changing speed."""

import math

import numpy as np
import pytest
from controller_bench import SAMPLES, synchronous
from rig import pack

from amb_cosim.model_constants.controller_data import inverse_receptance
from rolac_controller.adaptation import integral_step
from rolac_controller.enumerations import ADAPTING, NO_H, TOO_SLOW
from rolac_controller.parameters import BEARING_K_I


def test_optimum_is_the_weighted_one(responding, receptance, unbalance_response):
    weights = np.array([1.0, 4.0, 0.0, 1.0, 2.0, 1.0, 0.5, 1.0])
    b, run = responding(**{f"s{k + 1}__weight": w for k, w in enumerate(weights)})
    root = np.sqrt(weights)
    expected = np.linalg.lstsq(root[:, None] * receptance, -root * unbalance_response, rcond=None)[0]
    np.testing.assert_allclose(run(12000), expected, rtol=1e-6)
    assert b["harmonic1.force"] == pytest.approx(np.linalg.norm(expected), rel=1e-6)


def test_law_converges_at_exactly_alpha_when_q_follows_at_once(receptance, optimum, unbalance_response):
    H, sample_time, alpha = inverse_receptance(receptance), 250e-6, 7.0
    U, delta_U = np.zeros((2, 4), dtype=complex)
    for n in range(1, 2001):
        integral_step(H, alpha * sample_time, unbalance_response + receptance @ U, delta_U)
        U += delta_U
        if n % 500 == 0:
            expected = optimum * (1.0 - (1.0 - alpha * sample_time) ** n)
            np.testing.assert_allclose(U, expected, rtol=1e-9)


def settling_time(alpha, period):
    """Time after which e' = -alpha (mean of e over the last period), e = 1 before, has fallen to 1/e."""
    h = 1e-5
    n = round(period / h)
    e = np.ones(n + round(1.0 / alpha / h) + 1)
    total = float(n)
    for k in range(n, len(e) - 1):
        e[k + 1] = e[k] - alpha * h * total / n
        total += e[k + 1] - e[k + 1 - n]
    return (np.argmax(e < 1.0 / math.e) - n) * h


@pytest.mark.parametrize(("frequency", "of_alpha"), [(100, 0.97), (35, 0.90), (20, 0.83), (16, 0.79), (10, 0.72)])
def test_error_falls_to_1_over_e_as_its_delay_equation_predicts(responding, optimum, frequency, of_alpha):
    """Within 20 % of 1/alpha where alpha T < 0.4; slower rotors settle faster, nearly to 1/alpha - T/2."""
    samples, alpha = 4000 / frequency, 7.0
    b, run = responding(samples=samples, rolac_enable=0.0)
    run(math.ceil(samples) + 5)
    b["rolac_enable"] = 1.0
    n = 0
    while np.linalg.norm(run(1) - optimum) > np.linalg.norm(optimum) / math.e:
        n += 1
    assert n * b.h == pytest.approx(settling_time(alpha, 1.0 / frequency), rel=0.01)
    assert n * b.h * alpha == pytest.approx(of_alpha, abs=0.01)


def test_wrong_sign_of_h_diverges(responding, receptance):
    _, run = responding(-receptance)
    early, late = np.linalg.norm(run(1000)), np.linalg.norm(run(1000))
    assert late > 4.0 * early > 0.0


def test_force_turns_with_the_rotor_on_top_of_the_pid(responding):
    """I = I_pid + (Re[U] cos(theta) - Im[U] sin(theta))/K_i."""
    b, run = responding(pid=False)
    for _ in range(300):
        theta = b.theta
        u = run(1)[0]
        expected = (u.real * math.cos(theta) - u.imag * math.sin(theta)) / BEARING_K_I
        assert b["mb1.i_x"] == pytest.approx(expected, rel=1e-10, abs=1e-13)
    assert abs(u) > 1.0


@pytest.mark.parametrize("frequency", [-16.0, 0.0, 4.9])
def test_pid_works_alone_below_5_hz_at_standstill_and_backward(bench, receptance, frequency):
    with_rolac = bench(pack([1.0], [receptance]), Omega=2.0 * math.pi * frequency, rolac_enable=1.0)
    alone = bench(Omega=2.0 * math.pi * frequency)
    for b in (with_rolac, alone):
        b.follow(lambda theta: np.full(8, 1e-4 * math.sin(theta + 1.0)), 1500)
    assert with_rolac["rolac_active"] == 0.0
    assert with_rolac["rolac_status"] == TOO_SLOW
    assert with_rolac["mb1.i_x"] == alone["mb1.i_x"] != 0.0


def test_currents_stay_within_their_limits_with_rolac(responding, receptance):
    b, run = responding(-receptance, rolac__force_limit=1e9)
    currents, limited = [], []
    for _ in range(3000):
        run(1)
        currents.append(b["mb1.i_x"])
        limited.append(b["current_limited"])
    assert min(currents) == -5.57
    assert max(currents) == 4.43
    assert limited[0] == 0.0
    assert max(limited) == 1.0


def test_force_is_limited_in_amplitude_and_keeps_its_phase(responding, receptance, optimum, unbalance_response):
    limit = 0.6 * np.abs(optimum).max()
    b, run = responding(rolac__force_limit=limit)
    forces = run(6000)
    assert np.abs(forces).max() == pytest.approx(limit, rel=1e-12)
    assert b["rolac_limited"] == 1.0
    free = np.abs(forces) < 0.999 * limit
    assert free.any()
    assert not free.all()
    residual = unbalance_response + receptance @ forces
    drive = inverse_receptance(receptance) @ residual
    np.testing.assert_allclose(np.angle(drive[~free] / forces[~free]), 0.0, atol=1e-6)  # it pushes straight outward


def test_limited_force_does_not_wind_up(responding, optimum):
    """When the unbalance is removed, the force leaves its limit as fast as from an unlimited value of that size."""
    b, run = responding(rolac__force_limit=0.3 * np.abs(optimum).min())
    at_limit = run(20000)
    assert b["rolac_limited"] == 1.0
    b["rolac.alpha"] = 0.0
    np.testing.assert_allclose(run(1, lambda n: 0.0), at_limit, rtol=1e-12)
    b["rolac.alpha"] = 7.0
    start, end = (np.abs(run(count, lambda n: 0.0)).max() for count in (SAMPLES + 2, round(1.0 / 7.0 / b.h)))
    assert end == pytest.approx(start / math.e, rel=0.15)


def test_limit_holds_for_the_sum_over_the_harmonics(bench, receptance, speed_of):
    constants = pack([1.0], [[receptance], [receptance]], orders=(1, 2))
    b = bench(constants, Omega=speed_of(80), harmonic2__order=2, rolac__force_limit=20.0, rolac_enable=1.0)
    b.follow(lambda theta: np.full(8, 1e-4) * (math.cos(theta) + math.cos(2 * theta)), 4000)
    amplitudes = np.abs(b.forces())
    b["shown_harmonic"] = 2
    b.sample()
    total = amplitudes + np.abs(b.forces())
    assert total.max() == pytest.approx(20.0, rel=2e-2)


def test_several_harmonics_reach_their_own_optimum_side_by_side(bench, receptance, speed_of, unbalance_response):
    """Q_n = Q_n0 + R_n U_n for n = 1 and 3, each with its receptance; the plant receives the force over time."""
    other = 1j * receptance[::-1]
    constants = pack([1.0], [[receptance], [other]], orders=(1, 3))
    b = bench(constants, Omega=speed_of(120), pid=False, harmonic2__order=3, rolac_enable=1.0)
    unbalance = {1: unbalance_response, 3: 0.3 * unbalance_response[::-1]}
    forces = {1: np.zeros(4, complex), 3: np.zeros(4, complex)}
    for n in range(16000):
        q1, q3 = unbalance[1] + receptance @ forces[1], unbalance[3] + other @ forces[3]
        b.sense((q1 * np.exp(1j * b.theta) + q3 * np.exp(3j * b.theta)).real)
        b["shown_harmonic"] = 1 + n % 2
        b.sample()
        forces[1 + 2 * (n % 2)] = b.forces()
    np.testing.assert_allclose(forces[1], np.linalg.lstsq(receptance, -unbalance[1], rcond=None)[0], rtol=1e-4)
    np.testing.assert_allclose(forces[3], np.linalg.lstsq(other, -unbalance[3], rcond=None)[0], rtol=1e-4)
    theta = b.theta - b["Omega"] * b.h
    turning = sum((u * np.exp(1j * k * theta)).real for k, u in forces.items())
    np.testing.assert_allclose(b.axis_forces(), turning, rtol=2e-2, atol=0.05)


def test_harmonic_without_h_adds_no_force_and_is_flagged(bench, receptance, speed_of):
    b = bench(pack([1.0], [receptance]), Omega=speed_of(80), harmonic2__order=2, rolac_enable=1.0)
    b.follow(synchronous, 200)
    assert b["rolac_status"] == NO_H
    assert not b.forces().any()


@pytest.mark.parametrize(
    ("speed", "extrapolate", "expected"),
    [
        *((speed, 1.0, (ADAPTING, 1.0, True)) for speed in (40.0, 400.0)),
        *((speed, 0.0, (NO_H, 0.0, False)) for speed in (40.0, 400.0)),
        (100.0, 1.0, (ADAPTING, 0.0, True)),
    ],
)
def test_h_beyond_the_table_is_that_of_its_end_or_missing(bench, receptance, speed, extrapolate, expected):
    table = pack([50.0, 300.0], [receptance, receptance])
    b = bench(table, Omega=speed, rolac__extrapolate=extrapolate, rolac_enable=1.0)
    b.follow(synchronous, 1000)
    assert (b["rolac_status"], b["h_extrapolated"], np.abs(b.forces()).max() > 0.0) == expected


def test_h_follows_the_speed_in_a_run_up(bench, receptance, unbalance_response):
    """The receptance rotates by 360 degrees between 10 and 40 Hz; with H of one speed ROLAC would diverge."""
    speeds = 2.0 * np.pi * np.linspace(10.0, 40.0, 31)

    def at(speed):
        return receptance * np.exp(-2j * math.pi * (speed - speeds[0]) / (speeds[-1] - speeds[0]))

    def largest(table):
        b = bench(table, Omega=speeds[0], rolac_enable=1.0)
        vibration = []
        for n in range(40000):
            b["Omega"] = speeds[0] + (speeds[-1] - speeds[0]) * min(max(n - 4000, 0) / 32000, 1.0)
            q = unbalance_response + at(b["Omega"]) @ b.forces()
            b.sense((q * np.exp(1j * b.theta)).real)
            b.sample()
            vibration.append(b["harmonic1.displacement"])
        return np.max(vibration[4000:]), vibration[3999]

    peak, settled = largest(pack(speeds, [at(s) for s in speeds]))
    assert peak < 1.15 * np.linalg.norm(unbalance_response)
    assert settled < 0.95 * np.linalg.norm(unbalance_response)
    fixed, _ = largest(pack(speeds[:1], [at(speeds[0])]))
    assert fixed > 3.0 * peak


def test_table_may_be_missing_only_if_an_identification_is_requested(bench):
    b = bench(Omega=100.0)
    b["identify"] = b["rolac_enable"] = 1.0
    b.follow(synchronous, 400)
    assert b["rolac_active"] == 0.0
    b["identify"] = 0.0
    b.follow(synchronous, 2)
    assert b["rolac_status"] == NO_H
