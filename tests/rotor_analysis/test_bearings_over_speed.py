"""Bearings whose stiffness and damping depend on the spin speed."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import tensor

from rotor_analysis.campbell import campbell
from rotor_analysis.modes import eigenvalues, modes
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.response import unbalance_response
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

RIG = load_rotor()


SOFTENING = tuple(AtSpeed(speed, tensor(k, 1e3 * speed), tensor(c)) for speed, k, c in (
    (0.0, 1.2e6, 6e3), (100.0, 1.0e6, 5e3), (250.0, 0.6e6, 4e3), (400.0, 0.5e6, 2e3),
))  # fmt: skip
TABLED = replace(RIG, bearings=tuple(Bearing(b.name, b.node, at_speed=SOFTENING) for b in RIG.bearings))


def held_at(Omega):
    """The rig on bearings with the coefficients of one speed."""
    K, C, _ = TABLED.bearings[0].at(Omega)
    bearings = (Bearing(b.name, b.node, K.tolist(), C.tolist()) for b in TABLED.bearings)
    return replace(RIG, bearings=tuple(bearings))


def test_table_is_met_and_held_beyond_its_ends():
    bearing = TABLED.bearings[0]
    for row in SOFTENING:
        stiffness, damping, _ = bearing.at(row.speed)
        np.testing.assert_allclose(stiffness, row.stiffness, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(damping, row.damping, rtol=1e-12, atol=1e-9)
    for beyond, last in ((500.0, 400.0), (-50.0, 0.0)):
        np.testing.assert_array_equal(bearing.at(beyond)[0], bearing.at(last)[0])


@pytest.mark.parametrize(("count", "order"), [(2, 1), (3, 2), (5, 3)])
def test_polynomial_up_to_the_third_degree_is_interpolated_exactly(count, order):
    speeds = np.linspace(0.0, 400.0, count)
    bearing = Bearing("a", 1, at_speed=tuple(AtSpeed(s, tensor(1e6 + s**order), tensor(1e3)) for s in speeds.tolist()))
    assert bearing.at(130.0)[0][0, 0] == pytest.approx(1e6 + 130.0**order, rel=1e-12)


@pytest.mark.parametrize("planes", [None, RIG.masters], ids=["full", "condensed"])
@pytest.mark.parametrize("Omega", [60.0, 250.0, 600.0])
def test_analyses_at_a_speed_have_the_bearings_of_that_speed(planes, Omega):
    tabled, held = (supported_rotor(rotor, planes=planes) for rotor in (TABLED, held_at(Omega)))
    result, exact = (np.array([mode.eigenvalue for mode in modes(s.model, Omega, 6)]) for s in (tabled, held))
    np.testing.assert_allclose(result, exact, rtol=1e-9)
    result, exact = (unbalance_response(s, {1: 1e-3}, np.array([Omega]), (4, 11)) for s in (tabled, held))
    np.testing.assert_allclose(result, exact, rtol=1e-12)


def test_critical_speed_is_one_on_the_bearings_of_that_speed():
    result = [c for c in campbell(supported_rotor(TABLED).model, np.linspace(0.0, 300.0, 40)).critical_speeds]
    assert result
    for critical in result:
        values = eigenvalues(supported_rotor(held_at(critical.Omega)).model, critical.Omega)
        assert np.min(np.abs(np.abs(values.imag) - critical.Omega)) < 1e-6 * critical.Omega


def test_condensation_keeps_a_bearing_over_speed():
    with raises_naming(ValueError, "node 4", "mb1"):
        supported_rotor(TABLED, planes=(1, 11, 13))


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"at_speed": SOFTENING[:1]}, ("at_speed", "[0.0] rad/s", "ascending, two or more")),
        ({"at_speed": SOFTENING[::-1]}, ("at_speed", "ascending, two or more")),
        ({"at_speed": SOFTENING, "stiffness": 1e6}, ("stiffness", "at_speed")),
    ],
)
def test_table_that_is_none_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        Bearing("a", 1, **changes)
