"""The force laws: the thesis's constants, properties shared by all laws, and their gradients.

The reference is (2.6) as it stands in the thesis, written down here once more.
"""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amb_actuator.force import (
    Coils,
    current_stiffness,
    force,
    limited_current,
    linear_force,
    negative_stiffness,
    nonlinear_force,
    pull,
)
from amb_actuator.interface import LAWS, LINEAR, MEASURED
from amb_cosim.model_constants.magnetic_bearing import axis_parameters

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text())["amb"]

# Table 2.2: N, A_e (m^2), l (m), phi (rad), I_b (A), I_s (A).
TABLE_2_2 = (158.0, 1399e-6, 1.2e-3, math.radians(22.5), 4.43, 1.14)
RIG = axis_parameters()
IRON_FREE = axis_parameters(b_sat=1000.0)
SYMMETRIC = axis_parameters(static_current=0.0)


def thesis_force(x, i_c, turns, area, gap, phi, bias, static):
    """Equation (2.6): attraction of the upper coil pair minus that of the lower one."""
    upper = ((static + bias + i_c) / (gap - x)) ** 2
    lower = ((bias - i_c) / (gap + x)) ** 2
    return 4e-7 * math.pi * turns**2 * area * math.cos(phi) * (upper - lower)


def magnet_of(turns, area, gap, phi, bias, static):
    """Parameters of an axis with this magnet and no limit of current that would matter."""
    return axis_parameters(
        turns=turns, pole_area=area, gap=gap, half_angle=phi, bias_current=bias, static_current=static, current_limit=99
    )


def healthy(i_c):
    return Coils(i_c, i_c, 1.0, 1.0)


displacements = st.floats(-1.1e-3, 1.1e-3)
currents = st.floats(-5.57, 4.43)
shares = st.floats(0.0, 1.0)
coils = st.builds(Coils, currents, currents, shares, shares)
laws = st.sampled_from(range(len(LAWS)))


def test_the_constants_of_table_2_2_have_the_printed_digits_of_the_thesis():
    k_s, k_i = negative_stiffness(magnet_of(*TABLE_2_2)), current_stiffness(magnet_of(*TABLE_2_2))
    assert round(k_s / 1e3) == THESIS["k_s_theory_N_per_m"] / 1e3 == 2377
    assert round(k_i) == THESIS["k_i_theory_N_per_A"] == 563
    assert (k_s / 1e3, k_i) == pytest.approx((2376.96, 563.15), abs=0.005)


magnets = st.tuples(
    st.floats(50, 500),
    st.floats(1e-4, 1e-2),
    st.floats(2e-4, 3e-3),
    st.floats(0, 0.8),
    st.floats(0.5, 10),
    st.floats(0, 5),
)


@given(magnets)
def test_both_constants_are_the_slopes_of_the_nonlinear_law_at_the_centre(magnet):
    gap, bias = magnet[2], magnet[4]
    dx, di = 1e-4 * gap, 1e-4 * bias
    slope_x = (thesis_force(dx, 0, *magnet) - thesis_force(-dx, 0, *magnet)) / (2 * dx)
    slope_i = (thesis_force(0, di, *magnet) - thesis_force(0, -di, *magnet)) / (2 * di)
    assert negative_stiffness(magnet_of(*magnet)) == pytest.approx(slope_x, rel=1e-6)
    assert current_stiffness(magnet_of(*magnet)) == pytest.approx(slope_i, rel=1e-6)


@given(displacements, currents)
def test_nonlinear_law_without_saturation_is_that_of_the_thesis(x, i_c):
    expected = thesis_force(x, i_c, *TABLE_2_2) - thesis_force(0, 0, *TABLE_2_2)
    result, _ = nonlinear_force(IRON_FREE, x, healthy(i_c))
    assert result == pytest.approx(expected, rel=1e-12, abs=1e-9)


@given(laws, displacements, coils)
def test_force_is_odd_where_both_coil_pairs_are_alike(law, x, c):
    """Without static current, mirroring displacement and coils turns the force round and keeps the gradient."""
    c = Coils(max(c.upper, -4.43), min(c.lower, 4.43), c.upper_turns, c.lower_turns)
    mirrored = Coils(-c.lower, -c.upper, c.lower_turns, c.upper_turns)
    forward, mirror_image = force(law, SYMMETRIC, x, c), force(law, SYMMETRIC, -x, mirrored)
    assert mirror_image[0] == pytest.approx(-forward[0], rel=1e-9, abs=1e-6)
    assert mirror_image[1] == pytest.approx(forward[1], rel=1e-9, abs=1e-3)


@given(laws, displacements, coils, st.sampled_from([RIG, IRON_FREE, SYMMETRIC, axis_parameters(knee_width=1.0)]))
def test_gradient_is_the_slope_of_the_force_over_displacement(law, x, c, p):
    """Central differences, for every law, current, loss of turns, in and out of saturation.

    Their error is of second order where the slope is smooth and of first at the two ends of the knee.
    """
    dx = 1e-9
    slope = (force(law, p, x + dx, c)[0] - force(law, p, x - dx, c)[0]) / (2 * dx)
    stiff = negative_stiffness(magnet_of(*TABLE_2_2)) / (1 - abs(x) / 1.2e-3) ** 4
    assert force(law, p, x, c)[1] == pytest.approx(slope, rel=1e-5, abs=1e-5 * stiff)


@given(displacements, currents)
def test_pull_per_ampere_and_per_metre_are_its_slopes(x, i_c):
    i, distance = 5.57 + i_c, RIG.gap - x
    di, dl = 1e-6, 1e-9
    at = pull(RIG, i, distance)
    by_current = (pull(RIG, i + di, distance).force - pull(RIG, i - di, distance).force) / (2 * di)
    by_distance = (pull(RIG, i, distance + dl).force - pull(RIG, i, distance - dl).force) / (2 * dl)
    steep = 3e3 / (1 - abs(x) / 1.2e-3) ** 3
    assert at.per_current == pytest.approx(by_current, rel=1e-5, abs=1e-5 * steep)
    assert -at.per_distance == pytest.approx(by_distance, rel=1e-5, abs=1e-2 * steep)


@given(displacements, currents)
def test_healthy_linear_laws_are_2_7_to_the_last_bit(x, i_c):
    k_s, k_i = negative_stiffness(magnet_of(*TABLE_2_2)), current_stiffness(magnet_of(*TABLE_2_2))
    assert force(LINEAR, RIG, x, healthy(i_c)) == (k_s * x + k_i * i_c, k_s)
    assert force(MEASURED, RIG, x, healthy(i_c)) == (1.944e6 * x + 544.0 * i_c, 1.944e6)


@given(coils)
def test_linear_law_has_the_static_pull_of_the_remaining_turns(c):
    """At the centre: exact in the lost bias, linear in the control current (its square is neglected)."""
    a, b = 5.57, 4.43
    k = current_stiffness(magnet_of(*TABLE_2_2)) / (2 * (a + b))
    n_u, n_l = c.upper_turns**2, c.lower_turns**2
    exact = k * (n_u * (a + c.upper) ** 2 - n_l * (b - c.lower) ** 2 - (a**2 - b**2))
    level = (a + c.upper + b - c.lower) / (a + b)
    control = a + c.upper - level * a
    result, _ = linear_force(RIG, 0.0, current_stiffness(magnet_of(*TABLE_2_2)), 0.0, c)
    assert result == pytest.approx(exact - k * (n_u - n_l) * control**2, rel=1e-9, abs=1e-6)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.05, 1.0))
def test_linear_law_is_tangent_to_the_nonlinear_one_with_faults(upper, lower, level):
    """Turns lost and bias decayed to a share `level`, no control current."""
    c = Coils((level - 1.0) * 5.57, (1.0 - level) * 4.43, upper, lower)
    linear, nonlinear = force(LINEAR, RIG, 0.0, c), nonlinear_force(IRON_FREE, 0.0, c)
    assert linear[0] == pytest.approx(nonlinear[0], rel=1e-9, abs=1e-9)
    assert linear[1] == pytest.approx(nonlinear[1], rel=1e-9)


@pytest.mark.parametrize("static", [0.0, 1e-305])  # the square of the second is zero, too
def test_axis_without_any_bias_has_no_force(static):
    p = axis_parameters(bias_current=0.0, static_current=static)
    assert force(LINEAR, p, 1e-4, healthy(0.0)) == (0.0, 0.0)
    assert nonlinear_force(p, 1e-4, healthy(0.0)) == (0.0, 0.0)


@given(st.floats(-100, 100), st.floats(0, 6), st.floats(0, 4))
def test_a_demand_is_cut_only_where_a_coil_reaches_its_limit(demand, bias, static):
    current = limited_current(demand, bias, static, 10.0, 0.0)
    coils = static + bias + current, bias - current
    assert all(-1e-12 <= coil <= 10 + 1e-12 for coil in coils)
    if current != demand:
        assert min(min(abs(coil), abs(coil - 10)) for coil in coils) < 1e-9
        assert abs(current) <= abs(demand)
