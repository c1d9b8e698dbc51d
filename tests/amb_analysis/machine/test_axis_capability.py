"""What a bearing axis can do, each figure against another way to find it."""

import math

import numpy as np
import pytest
from running_actuator import running_actuator

from amb_actuator.interface import DYNAMIC, NONLINEAR
from amb_analysis.machine.axis_capability import (
    current_amplitude,
    force_slew_rate,
    full_swing_bandwidth,
    linear_error,
    linear_range,
    load_capacity,
)
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, current_range
from tests.support.messages import raises_naming

RIG = axis_parameters()
IRON_FREE = axis_parameters(b_sat=1000.0)
F_0 = 320.9959
PER_AXIS = 500.0 / math.sqrt(2.0)  # Table 2.2: 500 N on a bearing with axes at 45 degrees


@pytest.mark.parametrize(
    ("refused", "facts"),
    [
        (lambda: linear_error(RIG, math.nan, 0.0), ("x", "nan m")),
        (lambda: linear_range(RIG, 1.0), ("tolerance = 1", "0", "1")),
        (lambda: full_swing_bandwidth(RIG, 5.0), ("amplitude", "5 A", "> 0 A", "<= 4.43 A")),
        (lambda: load_capacity(RIG, [-600.0]), ("load", "-600 N", ">= -552.589 N")),
        (lambda: load_capacity(RIG, [100.0, 1200.0]), ("load", "1200 N")),
    ],
)
def test_errors_name_value_and_limit(refused, facts):
    with raises_naming(ValueError, *facts):
        refused()


def test_linear_law_is_exact_in_the_current_without_saturation():
    i_c = np.linspace(*current_range(IRON_FREE), 11)
    np.testing.assert_allclose(linear_error(IRON_FREE, 0.0, i_c), 0.0, atol=1e-12)
    assert linear_range(IRON_FREE).i_c == current_range(IRON_FREE)


def test_linear_range_ends_where_the_error_reaches_five_percent():
    result = linear_range(RIG)
    assert result.x[0] < 0.0 < result.x[1]
    for x in result.x:
        assert linear_error(RIG, x, 0.0) == pytest.approx(0.05, abs=1e-6)
        assert np.max(linear_error(RIG, np.linspace(0.0, 0.999 * x, 200), 0.0)) < 0.05
    for i in result.i_c:
        assert linear_error(RIG, 0.0, i) == pytest.approx(0.05, abs=1e-6)
        assert np.max(linear_error(RIG, 0.0, np.linspace(0.0, 0.999 * i, 200))) < 0.05


def test_linear_range_along_x_is_that_of_the_series_of_the_law():
    """F/(K_s x) - 1 = 3/2 (a^2 - b^2)/(a^2 + b^2) xi + 2 xi^2 + O(xi^3), xi = x/l, for small tolerances."""
    a, b = 5.57, 4.43
    xi = np.max(np.roots([2.0, 1.5 * (a**2 - b**2) / (a**2 + b**2), -1e-4]).real)
    assert linear_range(IRON_FREE, 1e-4).x[1] == pytest.approx(xi * 1.2e-3, rel=1e-3)


def test_slew_rate_agrees_with_the_model():
    rise, fall = force_slew_rate(RIG)
    h = 1e-7
    for demand, expected in ((4.0, rise), (-4.0, -fall)):
        actuator = running_actuator(force_law=NONLINEAR, amplifier=DYNAMIC)
        actuator["mb1.i_x"] = demand
        actuator.step(0.0, h)
        assert actuator["mb1.f_x"] / h == pytest.approx(expected, rel=1e-4)
    assert 0.5 * (rise + fall) == pytest.approx(563.15 * 150.0 / 0.0732, rel=1e-5)


def test_voltage_and_current_bound_the_sine_that_the_coils_can_follow():
    assert current_amplitude(RIG, 0.0) == pytest.approx(4.43)
    for amplitude in (0.5, 1.0, 4.0):
        f = full_swing_bandwidth(RIG, amplitude)
        assert current_amplitude(RIG, f) == pytest.approx(amplitude, rel=1e-12)
        peak = 0.365 * 5.57 + amplitude * abs(0.365 + 2j * math.pi * f * 0.0732)
        assert peak == pytest.approx(150.0, rel=1e-12)
    assert np.all(np.diff(current_amplitude(RIG, np.linspace(80.0, 2000.0, 50))) < 0.0)


def test_the_coil_pair_with_the_larger_current_bounds_the_sine():
    """The axis turned by 180 degrees: its lower coil pair has 5.57 A at rest, its upper one 4.43 A."""
    turned = axis_parameters(bias_current=5.57, static_current=-1.14)
    for frequency in (0.0, 100.0, 1400.0):
        assert current_amplitude(turned, frequency) == pytest.approx(current_amplitude(RIG, frequency), rel=1e-12)
    assert full_swing_bandwidth(turned, 4.0) == pytest.approx(full_swing_bandwidth(RIG, 4.0), rel=1e-12)
    assert force_slew_rate(turned) == pytest.approx(force_slew_rate(RIG)[::-1], rel=1e-12)


def test_static_load_is_carried_with_the_static_current_of_table_2_2():
    """Table 2.2 gives 1.14 A and 500 N: 321 N of an axis with 1.14 A, 354 N ask for 1.24 A."""
    result = load_capacity(RIG, np.array([F_0, PER_AXIS]))
    assert result.static_current[0] == pytest.approx(1.14, abs=1e-5)
    assert result.static_current[1] == pytest.approx(1.243, abs=1e-3)


def test_control_force_above_a_load_agrees_with_the_model():
    loads = np.array([0.0, 100.0, PER_AXIS, 900.0, 1147.41])
    result = load_capacity(RIG, loads)
    for load, static, up, down in zip(loads, *result, strict=True):
        values = {"force_law": NONLINEAR, "mb1.static_current_x": static, "mb1.current_limit_x": 10.0}
        assert running_actuator(values | {"mb1.i_x": 50.0})["mb1.f_x"] == pytest.approx(up, rel=1e-9)
        assert running_actuator(values | {"mb1.i_x": -50.0})["mb1.f_x"] == pytest.approx(-down, rel=1e-9)
        fallen = running_actuator(values | {"mb1.amplifier_off_x": 1.0})
        assert fallen["mb1.f_x"] == pytest.approx(-load, abs=1e-6), "without currents the load is all there is"
