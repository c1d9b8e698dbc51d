"""Ball bearings: Hertz contacts and loads of the balls against tables, catalogues and closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from ball_bearings.bearing import PRESSURE_LIMIT, BallBearing
from ball_bearings.hertz import SILICON_NITRIDE, STEEL, groove_contact
from tests.support.messages import raises_naming

SKF_6002 = BallBearing(balls=9, ball_diameter=4.762e-3, pitch_diameter=23.5e-3)
HARRIS_209 = BallBearing(balls=9, ball_diameter=12.7e-3, pitch_diameter=65e-3, clearance=15e-6)
PAIR = BallBearing(13, 6.35e-3, 35.5e-3, rows=2, contact_angle=math.radians(15.0), preload=80.0)


def test_load_of_a_ball_in_a_209_bearing_matches_harris():
    """T. A. Harris, Rolling Bearing Analysis: 8900 N on a 209 bearing with 15 um; 4536 N, 60.41 um by his tables."""
    assert HARRIS_209.largest_load(8900.0) == pytest.approx(4536.0, rel=5e-3)
    assert HARRIS_209.displacement_under(8900.0) == pytest.approx(60.41e-6, rel=5e-3)


def test_static_rating_of_6002_matches_its_catalogue():
    assert SKF_6002.static_rating == pytest.approx(2850.0, rel=1e-2)


@pytest.mark.parametrize("gamma", [-0.3, 0.0, 0.2])
@pytest.mark.parametrize("conformity", [0.51, 0.53, 0.58])
def test_contact_agrees_with_the_fit_of_brewe_and_hamrock(gamma, conformity):
    """kappa = 1.0339 r^0.636, E = 1.0003 + 0.5968/r, K = 1.5277 + 0.6023 ln r, r the ratio of both radii."""
    D, along = 8e-3, 2.0 * gamma / (1.0 - gamma)
    across, rolling = (2.0 - 1.0 / conformity) / D, (2.0 + along) / D
    r, total = rolling / across, rolling + across
    kappa, E, K = 1.0339 * r**0.636, 1.0003 + 0.5968 / r, 1.5277 + 0.6023 * math.log(r)
    common = 1.0 / STEEL.compliance  # E' of two bodies of steel
    stiffness = math.pi * kappa * common * math.sqrt(2.0 * E / (9.0 * total * K**3))
    contact = groove_contact(D, conformity, gamma, STEEL, STEEL)
    assert contact.stiffness == pytest.approx(stiffness, rel=0.04)


def test_ball_in_a_flat_groove_is_a_hertz_contact_on_a_plane():
    """Q = 4/3 E* sqrt(R) delta^1.5, p = 3 Q/(2 pi a^2) with a^3 = 3 Q R/(4 E*), E* = 1/(2 compliance)."""
    R, stiff = 4e-3, 0.5 / STEEL.compliance
    contact = groove_contact(2.0 * R, 1e3, 0.0, STEEL, STEEL)
    assert contact.stiffness == pytest.approx(4.0 / 3.0 * stiff * math.sqrt(R), rel=1e-3)
    a = (3.0 * 50.0 * R / (4.0 * stiff)) ** (1.0 / 3.0)
    assert contact.pressure(50.0) == pytest.approx(1.5 * 50.0 / (math.pi * a * a), rel=1e-3)


def test_pressure_is_the_force_over_the_ellipse():
    """The mean over the ellipse of a Hertz pressure is two thirds of its largest, so that p = 3 Q/(2 pi a b)."""
    contact = SKF_6002.contacts[0]
    assert contact.force_at(contact.pressure(700.0)) == pytest.approx(700.0, rel=1e-12)
    assert contact.pressure(8.0 * 100.0) == pytest.approx(2.0 * contact.pressure(100.0), rel=1e-12)


@pytest.mark.parametrize("balls", [7, 8, 16, 40])
def test_largest_load_without_clearance_is_that_of_stribeck(balls):
    """F = Q_max sum of cos^2.5 over the loaded half, 4.37 F/Z for many balls."""
    bearing = BallBearing(balls, 6e-3, 0.1)
    phi = 2.0 * math.pi * np.arange(balls) / balls
    total = np.sum(np.maximum(np.cos(phi), 0.0) ** 2.5)
    assert bearing.largest_load(300.0) == pytest.approx(300.0 / total, rel=1e-2)  # its balls move along, not across
    assert 300.0 / total == pytest.approx(4.37 * 300.0 / balls, rel=0.02)


def test_pair_without_preload_shares_the_force_by_its_angle():
    """F = 2 Z Q_max J cos(alpha), J = integral of cos^2.5 over the loaded half, over 2 pi = 0.2288."""
    pair = BallBearing(60, 2e-3, 0.1, rows=2, contact_angle=math.radians(15.0))
    J = quad(lambda phi: math.cos(phi) ** 2.5, -math.pi / 2.0, math.pi / 2.0)[0] / (2.0 * math.pi)
    assert pytest.approx(0.2288, rel=1e-3) == J
    expected = 10.0 / (2.0 * 60.0 * J * math.cos(math.radians(15.0)))
    assert pair.largest_load(10.0) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("bearing", [SKF_6002, HARRIS_209, PAIR])
@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_force_is_the_gradient_of_the_energy_of_its_balls(bearing, angle):
    """A pull of the wrong sign, or a direction that is not that of the approach, makes work in a closed loop."""
    at = np.array([21e-6, -13e-6, 4e-6])

    def energy(displacement):
        return 0.4 * np.sum(bearing.ball_loads(displacement, angle) ** (5.0 / 3.0)) / bearing.stiffness ** (2.0 / 3.0)

    step = 1e-9
    gradient = [(energy(at + step * e) - energy(at - step * e)) / (2.0 * step) for e in np.eye(3)]
    force = bearing.force(at, angle)
    np.testing.assert_allclose(-np.array(gradient), force, rtol=1e-5, atol=1e-4)
    assert force[0] < 0.0 < force[1]  # against the displacement


def test_preload_is_the_axial_force_of_each_row():
    Q = PAIR.ball_loads(np.zeros(3))
    assert np.ptp(Q) < 1e-9 * Q[0, 0]
    B = PAIR.groove_distance
    s = B + (Q[0, 0] / PAIR.stiffness) ** (2.0 / 3.0)
    assert np.sum(Q[0]) * math.sqrt(1.0 - (B * math.cos(PAIR.contact_angle) / s) ** 2) == pytest.approx(80.0, rel=1e-6)
    np.testing.assert_allclose(PAIR.force(np.zeros(3)), 0.0, atol=1e-9)


def test_preload_makes_a_pair_stiffer_and_clearance_a_row_softer():
    loose = BallBearing(13, 6.35e-3, 35.5e-3, rows=2, contact_angle=math.radians(15.0))
    assert PAIR.displacement_under(100.0) < 0.6 * loose.displacement_under(100.0)
    tight, wide = (BallBearing(9, 4.762e-3, 23.5e-3, clearance=c) for c in (-2e-6, 10e-6))
    assert tight.largest_load(200.0) < SKF_6002.largest_load(200.0) < wide.largest_load(200.0)
    assert wide.displacement_under(1e-3) == pytest.approx(5e-6, rel=0.1)  # half the clearance, without load


def test_ceramic_balls_are_stiffer_and_press_harder():
    ceramic = BallBearing(9, 4.762e-3, 23.5e-3, ball=SILICON_NITRIDE)
    assert ceramic.displacement_under(500.0) < SKF_6002.displacement_under(500.0)
    assert ceramic.pressure(100.0) > 1.05 * SKF_6002.pressure(100.0)


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [
        ({"balls": 16}, ("ball_diameter", "0.004762 m", "< 0.004585 m", "16 balls")),
        ({"ball_diameter": 0.03}, ("> 0 m", "< pitch_diameter = 0.0235 m")),
        ({"conformity": (0.5, 0.52)}, ("conformity", "inner", "0.5", "> 0.5")),
        ({"clearance": -80e-6}, ("clearance", "-8e-05 m")),
        ({"contact_angle": 0.3}, ("rows", "1", "2")),
        ({"preload": 5.0}, ("preload", "5 N", "0 N")),
        ({"rows": 3}, ("rows", "3", "1", "2")),
        ({"clearance": math.nan}, ("clearance",)),
    ],
)
def test_bearing_that_cannot_be_built_is_refused(wrong, facts):
    with raises_naming(ValueError, *facts):
        BallBearing(**({"balls": 9, "ball_diameter": 4.762e-3, "pitch_diameter": 23.5e-3} | wrong))


def test_force_beyond_the_races_is_refused():
    with raises_naming(ValueError, "force", "1e+12 N"):
        SKF_6002.displacement_under(1e12)
    assert SKF_6002.pressure(5.0 * SKF_6002.static_rating / 9.0) == pytest.approx(PRESSURE_LIMIT, rel=1e-9)


ANGULAR = BallBearing(13, 5.556e-3, 31e-3, rows=2, contact_angle=math.radians(25.0))
LOADED = BallBearing(13, 5.556e-3, 31e-3, rows=2, contact_angle=math.radians(25.0), preload=40.0)


def sum_of_balls(bearing, radial, axial):
    """Radial and axial force that the balls carry in the displacement under these forces."""
    return -bearing.force(bearing.displacement(radial, axial))


@pytest.mark.parametrize("bearing", [SKF_6002, HARRIS_209, PAIR])
def test_without_axial_force_nothing_changes_to_the_last_bit(bearing):
    for force in (0.0, 3.0, 700.0):
        x = bearing.displacement_under(force)
        assert bearing.displacement(force).tolist() == [x, 0.0, 0.0]
        assert bearing.largest_load(force) == float(np.max(bearing.ball_loads(np.array([x, 0.0, 0.0]))))


@pytest.mark.parametrize("bearing", [SKF_6002, HARRIS_209, ANGULAR, LOADED])
@pytest.mark.parametrize(("radial", "axial"), [(0.0, 110.0), (60.0, 110.0), (300.0, 110.0), (300.0, -5.0)])
def test_the_balls_carry_both_forces(bearing, radial, axial):
    np.testing.assert_allclose(sum_of_balls(bearing, radial, axial), [radial, 0.0, axial], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("bearing", [SKF_6002, HARRIS_209, ANGULAR])
def test_balls_share_an_axial_force_evenly(bearing):
    """Q = F_a/(Z sin(alpha)) with the angle under load; the other row of a pair without preload carries nothing."""
    Q, alpha = bearing.ball_loads(bearing.displacement(0.0, 250.0)), bearing.largest_contact_angle(0.0, 250.0)
    assert np.ptp(Q[0]) < 1e-9 * Q[0, 0]
    assert Q[0, 0] == pytest.approx(250.0 / (bearing.balls * math.sin(alpha)), rel=1e-9)
    assert not Q[1:].any()


def test_hand_calculation_of_the_weight_of_a_pump_on_13_balls():
    """108 N on 25 degrees: 108/(13 sin 25 deg) = 19.66 N per ball; the angle under load is a little larger."""
    assert ANGULAR.largest_load(0.0, 108.0) == pytest.approx(19.66, rel=0.04)
    assert math.degrees(ANGULAR.largest_contact_angle(0.0, 108.0)) == pytest.approx(26.0, abs=0.05)


def test_an_axial_force_takes_the_preload_of_the_other_row_over():
    """Until the other row is free, at 2^1.5 = 2.83 times the preload, the loaded row carries force plus other row."""
    light, heavy = (LOADED.ball_loads(LOADED.displacement(0.0, axial)) for axial in (40.0, 150.0))
    assert light[1].max() > 0.0
    assert not heavy[1].any()
    assert light[0, 0] < LOADED.ball_loads(np.zeros(3))[0, 0] + 40.0 / (13.0 * math.sin(math.radians(25.0)))


@pytest.mark.parametrize("share", [0.5, 1.0, 1.5])
def test_combined_loads_are_those_of_sjoevalls_integrals(share):
    """F_r = Z Q cos(alpha) J_r(eps), F_a = Z Q sin(alpha) J_a(eps), with a constant angle, as for many small balls."""
    alpha, Z = math.radians(40.0), 72
    bearing = BallBearing(Z, 1e-3, 0.1, rows=2, contact_angle=alpha)
    axial = 2.0
    radial = share * axial / math.tan(alpha)

    def integral(weight, eps):
        half = math.acos(max(1.0 - 2.0 * eps, -1.0))

        def load(psi):
            return max(1.0 - (1.0 - math.cos(psi)) / (2.0 * eps), 0.0) ** 1.5 * weight(psi)

        return quad(load, -half, half, limit=200)[0] / (2.0 * math.pi)

    Q = bearing.ball_loads(bearing.displacement(radial, axial))
    x, _, z = bearing.displacement(radial, axial)
    largest = 0.0
    forces = np.zeros(2)
    for sign in (1.0, -1.0):  # of both rows: eps = (1 + d_a tan(alpha)/d_r)/2, of d_a sin + d_r cos at the first ball
        top, spread = sign * z * math.sin(alpha) + x * math.cos(alpha), x * math.cos(alpha)
        if top <= 0.0:
            continue
        eps = 0.5 * top / spread
        q = bearing.stiffness * top**1.5
        largest = max(largest, q)
        forces += (
            Z
            * q
            * np.array(
                [math.cos(alpha) * integral(math.cos, eps), sign * math.sin(alpha) * integral(lambda psi: 1.0, eps)]
            )
        )
    np.testing.assert_allclose(forces, [radial, axial], rtol=0.02)
    assert np.max(Q) == pytest.approx(largest, rel=0.02)


def test_turning_the_load_turns_its_pattern():
    """By the angle between balls, the pattern moves by a ball; turned by half of it, it is another."""
    bearing, step = ANGULAR, 2.0 * math.pi / 13.0
    x, _, z = bearing.displacement(60.0, 110.0)
    first = bearing.ball_loads(np.array([x, 0.0, z]))
    turned = bearing.ball_loads(np.array([x * math.cos(step), x * math.sin(step), z]))
    np.testing.assert_allclose(np.roll(first, 1, axis=1), turned, rtol=1e-9, atol=1e-12)
    force = -bearing.force(np.array([x * math.cos(step), x * math.sin(step), z]))
    np.testing.assert_allclose(force, [60.0 * math.cos(step), 60.0 * math.sin(step), 110.0], rtol=1e-6)


def test_an_axial_force_of_the_other_sign_loads_the_other_row():
    down, up = (ANGULAR.ball_loads(ANGULAR.displacement(60.0, sign * 110.0)) for sign in (-1.0, 1.0))
    np.testing.assert_allclose(down[::-1], up, rtol=1e-9)
    assert ANGULAR.displacement(60.0, -110.0)[2] < 0.0 < ANGULAR.displacement(60.0, 110.0)[2]


def test_life_under_the_dynamic_rating_of_a_catalogue_is_a_million_turns():
    """SKF: C = 5.85 kN of a 6002 bearing."""
    assert SKF_6002.life(5850.0) == pytest.approx(1e6, rel=0.1)
    assert SKF_6002.life(585.0) == pytest.approx(1e9, rel=0.1)  # L = (C/P)^3


@pytest.mark.parametrize(
    ("ball", "pitch", "catalogue"),
    [(22.225e-3, 92.5e-3, 85.2e3), (36.5125e-3, 157.5e-3, 174e3), (50.8e-3, 235e-3, 276e3)],
)
def test_life_of_large_bearings_agrees_with_their_catalogue(ball, pitch, catalogue):
    """SKF 6312, 6320 and 6330; with D^1.8 for all, the lives of the last two would be 1.5 and 2.3 times as long."""
    bearing = BallBearing(8, ball, pitch, conformity=(0.52, 0.52))
    assert bearing.life(catalogue) == pytest.approx(1e6, rel=0.2)


def test_rating_of_balls_above_25_4_mm_grows_with_the_power_1_4():
    """ISO 281: 3.647 D^1.4 for D^1.8. Of bearings of one shape, the life under one force grows with (D^1.4)^3."""

    def life(ball):
        return BallBearing(8, 1e-3 * ball, 4.3e-3 * ball, conformity=(0.52, 0.52)).life(5e4)

    assert life(25.4) / life(12.7) == pytest.approx(2.0**5.4, rel=1e-4)
    assert life(50.8) / life(25.4) == pytest.approx(2.0**4.2, rel=1e-4)
    assert life(25.4001) / life(25.3999) == pytest.approx(1.0, abs=1e-4)


def test_life_under_an_axial_force_follows_from_the_load_of_a_ball():
    """All balls of a row carry the same, so that both races have the life (Q_c/Q)^3, by hand from the formula."""
    Q, D, Z, f = ANGULAR.largest_load(0.0, 500.0), 5.556, 13.0, 0.52
    g = D * math.cos(math.radians(25.0)) / 31.0
    lives = []
    for sign in (1.0, -1.0):
        race = (1.0 - sign * g) ** 1.39 / (1.0 + sign * g) ** (1.0 / 3.0)
        rated = 1.3 * 98.1 * (2.0 * f / (2.0 * f - 1.0)) ** 0.41 * race * (D / 31.0) ** 0.3 * D**1.8 / Z ** (1.0 / 3.0)
        lives.append((rated / Q) ** 3)
    both = sum(life ** (-10.0 / 9.0) for life in lives) ** -0.9
    assert ANGULAR.life(0.0, 500.0) == pytest.approx(1e6 * both, rel=1e-9)
    assert ANGULAR.life(0.0, 500.0) == ANGULAR.life(0.0, -500.0)
    assert math.isinf(ANGULAR.life(0.0))


def test_an_axial_force_beyond_the_races_is_refused():
    with raises_naming(ValueError, "axial force", "1e+12 N"):
        ANGULAR.displacement(0.0, 1e12)
    with raises_naming(ValueError, "force", "-1 N", ">= 0 N"):
        ANGULAR.displacement(-1.0, 10.0)
