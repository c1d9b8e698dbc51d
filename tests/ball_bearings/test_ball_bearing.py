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
