"""The linearised force law against the thesis and against the non-linear law it comes from."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amb_actuator.force import current_stiffness, limited_current, negative_stiffness

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text())["amb"]

# Table 2.2: N, A_e (m^2), l (m), phi (rad), I_b (A), I_s (A).
TABLE_2_2 = (158.0, 1399e-6, 1.2e-3, math.radians(22.5), 4.43, 1.14)


def nonlinear_force(x, i_c, turns, area, gap, phi, bias, static):
    """Equation (2.6): attraction of the upper coil pair minus that of the lower one."""
    upper = ((static + bias + i_c) / (gap - x)) ** 2
    lower = ((bias - i_c) / (gap + x)) ** 2
    return 4e-7 * math.pi * turns**2 * area * math.cos(phi) * (upper - lower)


def test_the_constants_have_the_printed_digits_of_the_thesis():
    k_s, k_i = negative_stiffness(*TABLE_2_2), current_stiffness(*TABLE_2_2)
    assert round(k_s / 1e3) == THESIS["k_s_theory_N_per_m"] / 1e3 == 2377
    assert round(k_i) == THESIS["k_i_theory_N_per_A"] == 563


def test_the_constants_of_table_2_2_to_five_digits():
    assert negative_stiffness(*TABLE_2_2) / 1e3 == pytest.approx(2376.96, abs=0.005)
    assert current_stiffness(*TABLE_2_2) == pytest.approx(563.15, abs=0.005)


def test_the_rigs_bias_of_4_3_and_5_7_ampere_gives_2392_newton_per_millimetre():
    turns, area, gap, phi, _, _ = TABLE_2_2
    assert negative_stiffness(turns, area, gap, phi, 4.3, 1.4) / 1e3 == pytest.approx(2392.5, abs=0.05)


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
    slope_x = (nonlinear_force(dx, 0, *magnet) - nonlinear_force(-dx, 0, *magnet)) / (2 * dx)
    slope_i = (nonlinear_force(0, di, *magnet) - nonlinear_force(0, -di, *magnet)) / (2 * di)
    assert negative_stiffness(*magnet) == pytest.approx(slope_x, rel=1e-6)
    assert current_stiffness(*magnet) == pytest.approx(slope_i, rel=1e-6)


def test_the_linear_law_errs_with_the_square_of_the_deflection():
    k_s = negative_stiffness(*TABLE_2_2)
    static = nonlinear_force(0, 0, *TABLE_2_2)
    errors = [nonlinear_force(x, 0, *TABLE_2_2) - static - k_s * x for x in (2e-6, 1e-6)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.01)


@given(st.floats(-100, 100), st.floats(0, 6), st.floats(0, 4))
def test_no_coil_current_ever_leaves_its_limits(demand, bias, static):
    current = limited_current(demand, bias, static, 10.0)
    upper, lower = static + bias + current, bias - current
    assert -1e-12 <= upper <= 10 + 1e-12
    assert -1e-12 <= lower <= 10 + 1e-12


@given(st.floats(-100, 100), st.floats(0.5, 6), st.floats(0, 4))
def test_a_demand_is_cut_only_when_a_coil_reaches_its_limit(demand, bias, static):
    current = limited_current(demand, bias, static, 10.0)
    if current != demand:
        coils = [static + bias + current, bias - current]
        assert min(min(abs(c), abs(c - 10)) for c in coils) < 1e-9
        assert abs(current) <= abs(demand)
