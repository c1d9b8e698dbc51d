"""Design figures without a simulation, each against another way to find it."""

import math

import numpy as np
import pytest
from code_blocks import example_of
from running_actuator import K, running_actuator

from amb_actuator.interface import NONLINEAR
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants, linearisation
from tests.support.messages import raises_naming

RIG = axis_parameters()


def test_parameters_are_those_of_the_table_with_changes():
    p = axis_parameters("mb2", "y", bias_current=4.3, static_current=1.4)
    assert (p.bias_current, p.static_current, p.gap, p.amplifier_gain) == (4.3, 1.4, 1.2e-3, 0.5)
    assert linear_constants(p)[0] / 1e3 == pytest.approx(2392.5, abs=0.05)


@pytest.mark.parametrize(
    ("refused", "facts"),
    [
        (lambda: axis_parameters("mb1", "w"), ("mb1.w", "mb1.x, mb1.y, mb1.z")),
        (lambda: axis_parameters(winding=1), ("'winding'", "turns, pole_area, gap")),
        (lambda: axis_parameters(turns=-158), ("mb1.turns_x", "-158", ">= 1")),
        (lambda: axis_parameters(gap=math.nan), ("mb1.gap_x", "nan m")),
        (lambda: axis_parameters(bias_current=9), ("bias_current", "9 A", "static_current", "1.14 A", "<= 10 A")),
        (lambda: linearisation(RIG, 1.2e-3), ("x", "0.0012 m", "> -0.0012 m", "< 0.0012 m")),
        (lambda: linearisation(RIG, 0.0, [0.0, 5.0]), ("i_c", "5 A", ">= -5.57 A", "<= 4.43 A")),
    ],
)
def test_errors_name_value_and_limit(refused, facts):
    with raises_naming(ValueError, *facts):
        refused()


def test_linearisation_agrees_with_the_model():
    """Force and gradient of the FMU, and its differences over the control current."""
    x, i_c = np.meshgrid([-4e-4, 0.0, 2e-4], [-3.0, 0.0, 0.7, 3.0])
    result = linearisation(RIG, x, i_c)
    assert result.force.shape == result.k_s.shape == result.k_i.shape == x.shape
    for at in np.ndindex(x.shape):
        force = [
            running_actuator(force_law=NONLINEAR, mb1__x=x[at], mb1__i_x=i_c[at] + d)["mb1.f_x"]
            for d in (-1e-6, 0.0, 1e-6)
        ]
        assert result.force[at] == force[1]
        assert result.k_s[at] == running_actuator(force_law=NONLINEAR, mb1__x=x[at], mb1__i_x=i_c[at])["mb1.k_xx"]
        assert result.k_i[at] == pytest.approx((force[2] - force[0]) / 2e-6, rel=1e-5, abs=1e-3)


def test_example_in_the_readme_prints_the_design_figures(capsys):
    exec(example_of("amb_cosim.model_constants"), {})
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines[0].startswith("K_s = 2392.5 N/mm")  # the rig's bias currents, thesis section 2.4
    static = math.sqrt(4.3**2 + 354.0 / K) - 4.3  # K ((I_b + I_s)^2 - I_b^2) = 354 N; saturation adds less than 1 mA
    assert lines[1:] == [f"I_s = {static:.3f} A carries 354 N"]
