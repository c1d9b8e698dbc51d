"""Flux saturation: B_sat for 1700 N, and the shape of the knee."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from running_actuator import F_0

from amb_actuator.flux import limited_flux, pull_of_flux, saturation_flux
from amb_actuator.force import Coils, nonlinear_force, pull
from amb_actuator.interface import NONLINEAR
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from tests.support.messages import raises_naming

AREA, PHI = 1399e-6, math.radians(22.5)
RIG = axis_parameters()


def test_the_limit_of_1700_newton_is_a_flux_density_of_1_29_tesla():
    assert RIG.b_sat == pytest.approx(1.29, abs=0.005)
    assert RIG.b_sat == pytest.approx(math.sqrt(4e-7 * math.pi * 1700.0 / (AREA * math.cos(PHI))), rel=1e-12)


@given(st.floats(1.0, 1e5), st.floats(1e-5, 1.0), st.floats(0.0, 1.5))
def test_flux_and_pull_are_inverse(force, area, phi):
    assert pull_of_flux(saturation_flux(force, area, phi), area, phi) == pytest.approx(force, rel=1e-12)


def test_saturation_flux_of_zero_force_is_refused():
    with raises_naming(ValueError, "force", "0 N", "> 0 N"):
        saturation_flux(0.0, AREA, PHI)


def test_ten_ampere_pull_1700_newton_and_2816_without_saturation():
    assert pull(RIG, 10.0, 1.2e-3).force == pytest.approx(1700.0, rel=1e-12)
    assert pull(axis_parameters(b_sat=1000.0), 10.0, 1.2e-3).force == pytest.approx(2816.0, abs=0.5)


def test_axis_reaches_1700_newton_at_full_current(bearing):
    made = bearing(force_law=NONLINEAR, mb1__i_x=100.0, mb2__i_y=-100.0)
    assert (made["mb1.i_upper_x"], made["mb1.i_lower_x"]) == (10.0, 0.0)
    assert made["mb1.f_x"] == pytest.approx(1700.0 - F_0, rel=1e-12)
    assert made["mb2.f_y"] == pytest.approx(-1700.0 - F_0, rel=1e-12)
    assert made["mb1.k_xx"] == pytest.approx(0.0, abs=1e-6)


@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(-1.19e-3, 1.19e-3), st.floats(0.0, 1.0))
def test_force_never_exceeds_1700_newton(upper, lower, x, width):
    p = axis_parameters(knee_width=width)
    result, gradient = nonlinear_force(p, x, Coils(upper - 5.57, 4.43 - lower, 1.0, 1.0))
    static = float(pull(p, 5.57, 1.2e-3).force - pull(p, 4.43, 1.2e-3).force)
    assert abs(result + static) <= 1700.0 * (1 + 1e-12)
    assert gradient >= 0.0


fluxes = st.floats(0.0, 20.0)
limits = st.floats(0.1, 3.0)
widths = st.floats(0.0, 1.0)


@given(fluxes, limits, widths)
def test_flux_is_neither_amplified_nor_beyond_its_limit(b, b_sat, width):
    flux, slope = limited_flux(b, b_sat, width)
    assert 0.0 <= flux <= min(b, b_sat) * (1 + 1e-15)
    assert 0.0 <= slope <= 1.0


@given(limits, widths)
def test_the_knee_begins_and_ends_smoothly(b_sat, width):
    for end, flux, slope in ((1 - width, (1 - width) * b_sat, 1.0), (1 + width, b_sat, 0.0)):
        for side in (1 - 1e-9, 1 + 1e-9):
            result = limited_flux(end * b_sat * side, b_sat, width)
            assert result[0] == pytest.approx(flux, abs=1e-8 * b_sat)
            if width > 1e-3:
                assert result[1] == pytest.approx(slope, abs=1e-5)


def test_half_way_through_the_knee_a_quarter_of_its_width_is_missing():
    flux, slope = limited_flux(1.0, 1.0, 0.2)
    assert flux == pytest.approx(1.0 - 0.2 / 4)
    assert slope == pytest.approx(0.5)


def test_flag_rises_at_the_knee_under_every_law(bearing):
    """0.8 B_sat is reached by 6.216 A in the upper pair, I_c = 0.646 A, with the rotor at the centre."""
    for law in range(3):
        for i_c, flag in ((0.6, 0.0), (0.64, 0.0), (0.65, 1.0), (-1.7, 0.0), (-1.8, 1.0)):
            assert bearing(force_law=law, mb1__i_x=i_c)["mb1.saturated_x"] == flag
    assert bearing(mb2__y=4e-4)["mb2.saturated_y"] == 1.0
    assert bearing(mb2__y=4e-4, mb2__coil_loss_upper_y=0.5)["mb2.saturated_y"] == 0.0
