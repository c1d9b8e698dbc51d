"""The matrix H, and the constants of an FMU with a table of it."""

import json
from pathlib import Path

import numpy as np
import pytest
from rig import pack

from amb_cosim.model_constants.controller_data import SPEEDS, condition_number, inverse_receptance
from tests.support.messages import raises_naming

THESIS = json.loads((Path(__file__).parents[2] / "reference" / "thesis.json").read_text(encoding="utf-8"))


def test_h_solves_the_normal_equations(receptance):
    adjoint = receptance.conj().T
    expected = -np.linalg.solve(adjoint @ receptance, adjoint)
    np.testing.assert_allclose(inverse_receptance(receptance), expected, rtol=1e-10, atol=1e-3)


def ill_conditioned(receptance):
    u, s, v = np.linalg.svd(receptance, full_matrices=False)
    s[-1] = s[0] / 3e5
    return u * s @ v


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda R: inverse_receptance(ill_conditioned(R)), ("condition number", "3e+05")),
        (lambda R: inverse_receptance(R.T), ("(4, 8)",)),
        *(
            (lambda R, speeds=speeds: pack(speeds, [R, R]), ("ascending",))
            for speeds in ([2.0, 1.0], [1.0, 1.0], [0.0, 1.0], [1.0, np.nan])
        ),
        (lambda R: pack([1.0, 2.0], [R]), ("2 speeds",)),
        (lambda R: pack([30.0, 62.5], [R, 0.0 * R]), ("at 62.5 rad/s", "condition")),
        *(
            (lambda R, orders=orders: pack([1.0], np.array([[R]] * len(orders)), orders), ("orders",))
            for orders in ((), (0,), (2, 1), (1, 1), (1, 51))
        ),
    ],
)
def test_receptances_without_an_inverse_for_each_speed_and_order_are_refused(receptance, call, facts):
    with raises_naming(ValueError, *facts):
        call(receptance)


def test_condition_number_of_a_singular_receptance_is_infinite():
    assert condition_number(np.zeros((8, 4))) == np.inf


def test_speeds_are_the_twelve_of_the_thesis():
    np.testing.assert_allclose(np.array(SPEEDS) / (2.0 * np.pi), THESIS["rolac"]["table_speeds_Hz"], rtol=1e-15)
