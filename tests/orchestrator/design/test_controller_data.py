"""The matrix H, and the constants of an FMU with a table of it."""

import json
from pathlib import Path

import numpy as np
import pytest
from rig import pack

from amb_cosim.design.controller_data import SPEEDS, condition_number, inverse_receptance
from tests.support.messages import raises_naming

THESIS = json.loads((Path(__file__).parents[2] / "reference" / "thesis.json").read_text(encoding="utf-8"))


def test_h_solves_the_normal_equations(receptance):
    adjoint = receptance.conj().T
    expected = -np.linalg.solve(adjoint @ receptance, adjoint)
    np.testing.assert_allclose(inverse_receptance(receptance), expected, rtol=1e-10, atol=1e-3)


def test_ill_conditioned_receptance_is_refused_with_the_number(receptance):
    u, s, v = np.linalg.svd(receptance, full_matrices=False)
    s[-1] = s[0] / 3e5
    with raises_naming(ValueError, "condition number", "3e+05"):
        inverse_receptance(u * s @ v)


def test_receptance_of_wrong_shape_is_refused(receptance):
    with pytest.raises(ValueError, match=r"\(4, 8\)"):
        inverse_receptance(receptance.T)


@pytest.mark.parametrize("speeds", [[2.0, 1.0], [1.0, 1.0], [0.0, 1.0], [1.0, np.nan]])
def test_speeds_that_do_not_ascend_are_refused(receptance, speeds):
    with pytest.raises(ValueError, match="ascending"):
        pack(speeds, [receptance, receptance])


def test_number_of_receptances_must_match_the_speeds(receptance):
    with raises_naming(ValueError, "2 speeds"):
        pack([1.0, 2.0], [receptance])


def test_a_receptance_that_cannot_be_inverted_names_its_speed(receptance):
    with pytest.raises(ValueError, match=r"at 62\.5 rad/s.*condition"):
        pack([30.0, 62.5], [receptance, 0.0 * receptance])


@pytest.mark.parametrize("orders", [(), (0,), (2, 1), (1, 1), (1, 51)])
def test_orders_that_do_not_ascend_from_one_are_refused(receptance, orders):
    with pytest.raises(ValueError, match="orders"):
        pack([1.0], np.array([[receptance]] * len(orders)), orders)


def test_condition_number_of_a_singular_receptance_is_infinite():
    assert condition_number(np.zeros((8, 4))) == np.inf


def test_speeds_are_the_twelve_of_the_thesis():
    np.testing.assert_allclose(np.array(SPEEDS) / (2.0 * np.pi), THESIS["rolac"]["table_speeds_Hz"], rtol=1e-15)
