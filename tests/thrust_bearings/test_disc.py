"""Force of a two-sided thrust disc: its slopes, signs, limits, and its moment under tilt, against closed forms."""

import math

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.integrate import dblquad

from tests.support.messages import raises_naming
from thrust_bearings.disc import CatalogueBearing, ThrustDisc, moment_stiffness

DATA = {
    "inner_radius": 0.025,
    "outer_radius": 0.055,
    "pole_area": 12e-4,
    "gap": 0.5e-3,
    "turns": 80.0,
    "bias_current": 4.0,
    "current_limit": 10.0,
    "saturation": 1.3,
}
DISC = ThrustDisc(**DATA)


def test_current_pulls_towards_its_magnet_and_displacement_further_away():
    assert DISC.force(0.0, 0.1) > 0.0 > DISC.force(0.0, -0.1)
    assert DISC.force(1e-5, 0.0) > 0.0 > DISC.force(-1e-5, 0.0)
    assert DISC.force(0.0, 0.0) == 0.0


@pytest.mark.parametrize("saturation", [1.3, 0.6])
@pytest.mark.parametrize("current", [0.0, 1.5, -3.0])
def test_constants_are_the_slopes_of_the_force(current, saturation):
    """Below saturation, and with one magnet saturated: that at 3 A and 0.6 T."""
    disc = ThrustDisc(**(DATA | {"saturation": saturation}))
    point = disc.operating_point(float(disc.force(0.0, current)))
    assert point.current == pytest.approx(current, abs=1e-9)
    step = 1e-4
    by_current = (disc.force(0.0, current + step) - disc.force(0.0, current - step)) / (2.0 * step)
    assert point.k_i == pytest.approx(by_current, rel=1e-7)
    step = 1e-7
    by_distance = (disc.force(step, current) - disc.force(-step, current)) / (2.0 * step)
    assert point.k_s == pytest.approx(by_distance, rel=1e-5)


def test_constants_at_rest_match_the_closed_form():
    k_i = mu_0 * 80.0**2 * 12e-4 * 4.0 / 0.5e-3**2
    assert DISC.operating_point().k_i == pytest.approx(k_i, rel=1e-12)
    assert DISC.operating_point().k_s == pytest.approx(k_i * 4.0 / 0.5e-3, rel=1e-12)
    loaded = DISC.operating_point(0.5 * DISC.capacity)
    assert loaded.k_i == pytest.approx(k_i, rel=1e-12)
    assert loaded.k_s == pytest.approx(1.25 * k_i * 4.0 / 0.5e-3, rel=1e-9)


def test_a_data_sheet_gives_the_same_bearing_below_saturation():
    rest = DISC.operating_point()
    sheet = CatalogueBearing(0.025, 0.055, rest.k_i, rest.k_s, DISC.capacity)
    for load in (0.0, 200.0, -600.0):
        assert sheet.operating_point(load) == pytest.approx(DISC.operating_point(load), rel=1e-9)
    assert sheet.rings == ((0.025, 0.055),)


@pytest.mark.parametrize("bearing", [DISC, CatalogueBearing(0.025, 0.055, 120.0, 1e6, 480.0)])
def test_a_load_beyond_the_capacity_is_refused(bearing):
    with pytest.raises(ValueError, match=r"force = -5000 N .* <= .* N"):
        bearing.operating_point(-5000.0)


def test_force_is_the_change_of_the_energy_of_its_gaps():
    """The work of a displacement at constant flux is the loss of energy B^2/(2 mu_0) of four gaps."""
    z, i, step = 0.1e-3, 1.2, 1e-9
    upper, lower = DISC.flux_densities(z, i)

    def energy(at):
        return 2.0 * DISC.pole_area / (2.0 * mu_0) * (upper**2 * (DISC.gap - at) + lower**2 * (DISC.gap + at))

    assert DISC.force(z, i) == pytest.approx(-(energy(z + step) - energy(z - step)) / (2.0 * step), rel=1e-6)


def test_capacity_is_that_of_all_control_current_below_saturation():
    assert DISC.largest_control_current == 4.0
    assert DISC.capacity == pytest.approx(DISC.operating_point().k_i * 4.0, rel=1e-12)
    assert DISC.capacity == pytest.approx(mu_0 * 80.0**2 * 12e-4 / 4.0 * (8.0 / 0.5e-3) ** 2, rel=1e-12)


def test_saturation_limits_the_capacity_to_that_of_its_flux_density():
    weak = ThrustDisc(**(DATA | {"saturation": 0.6}))
    assert weak.capacity == pytest.approx(12e-4 / mu_0 * 0.6**2, rel=1e-12)
    assert weak.operating_point() == pytest.approx(DISC.operating_point())


def test_a_low_current_limit_leaves_the_bias_of_the_other_coil():
    low = ThrustDisc(**(DATA | {"current_limit": 5.0}))
    scale = mu_0 * 80.0**2 * 12e-4 / (4.0 * 0.5e-3**2)
    assert low.capacity == pytest.approx(scale * (5.0**2 - 3.0**2), rel=1e-12)


def test_poles_have_their_area_and_lie_within_the_radii():
    for inner, outer in DISC.poles:
        assert math.pi * (outer**2 - inner**2) == pytest.approx(12e-4, rel=1e-12)
    (r_1, r_2), (r_3, r_4) = DISC.poles
    assert 0.025 == r_1 < r_2 < r_3 < r_4 == 0.055


@pytest.mark.parametrize("rings", [((0.02, 0.06),), DISC.poles])
def test_moment_of_a_tilted_disc_is_the_integral_over_its_rings(rings):
    area = sum(math.pi * (outer**2 - inner**2) for inner, outer in rings)
    kappa = 2e6 / area
    theta = 1e-3
    total = 0.0
    for inner, outer in rings:
        # force of an area times its lever r cos(phi)
        total += dblquad(
            lambda r, phi: kappa * (r * math.cos(phi) * theta) * r * math.cos(phi) * r, 0.0, 2.0 * math.pi, inner, outer
        )[0]
    assert moment_stiffness(2e6, rings) == pytest.approx(total / theta, rel=1e-9)
    assert moment_stiffness(2e6, rings) > 0.0  # turns it further


def test_forces_are_arrays_over_displacement_and_current():
    z, i = np.linspace(-1e-4, 1e-4, 5)[:, None], np.linspace(-2.0, 2.0, 7)
    F = DISC.force(z, i)
    assert F.shape == (5, 7)
    np.testing.assert_allclose(F, -F[::-1, ::-1], atol=1e-9)  # both magnets are alike


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [((0.06, 0.05, 1.0, 1.0, 1.0), ("outer_radius",)), ((0.0, 0.05, 120.0, -1.0, 400.0), ("k_s", "-1 N/m"))],
)
def test_an_impossible_data_sheet_is_refused(wrong, facts):
    with raises_naming(ValueError, *facts):
        CatalogueBearing(*wrong)


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [
        ({"outer_radius": 0.02}, ("outer_radius", "0.02 m", "> inner_radius = 0.025 m")),
        ({"pole_area": 40e-4}, ("pole_area", "0.004 m2", "> 0 m2", "< 0.00377 m2")),
        ({"gap": 0.0}, ("gap", "0 m", "> 0 m")),
        ({"gap": math.nan}, ("gap", "nan m")),
        ({"turns": -2.0}, ("turns", "-2", "> 0")),
        ({"current_limit": 4.0}, ("current_limit", "4 A", "> bias_current = 4 A")),
        ({"saturation": 0.3}, ("bias_current", "4 A", "0.402 T")),
    ],
)
def test_a_bearing_that_cannot_be_built_is_refused(wrong, facts):
    with raises_naming(ValueError, *facts):
        ThrustDisc(**(DATA | wrong))


def test_displacements_and_currents_beyond_the_limits_are_refused():
    with raises_naming(ValueError, "z", "0.0005 m", "< 0.0005 m"):
        DISC.force(5e-4, 0.0)
    with raises_naming(ValueError, "i", "-4.1 A", "<= 4 A"):
        DISC.force(0.0, np.array([0.0, -4.1]))
