"""Bearings whose stiffness and damping depend on the spin speed."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from analysis_cases import disc_between, tensor

from rotor_analysis.campbell import campbell
from rotor_analysis.modes import modes
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.response import unbalance_response
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

RIG = load_rotor()
LIFT_OFF = (2e4, 2e4, 2e4, 500.0, 500.0, 500.0)  # N s/m

SOFTENING = tuple(AtSpeed(speed, tensor(k, 1e3 * speed), tensor(c)) for speed, k, c in (
    (0.0, 1.2e6, 6e3), (100.0, 1.0e6, 5e3), (250.0, 0.6e6, 4e3), (400.0, 0.5e6, 2e3),
))  # fmt: skip
TABLED = replace(RIG, bearings=tuple(Bearing(b.name, b.node, at_speed=SOFTENING) for b in RIG.bearings))


def held_at(Omega):
    """The rig on bearings with the coefficients of one speed."""
    K, C, _ = TABLED.bearings[0].at(Omega)
    bearings = (Bearing(b.name, b.node, K.tolist(), C.tolist()) for b in TABLED.bearings)
    return replace(RIG, bearings=tuple(bearings))


def test_table_is_exact_at_its_speeds_and_constant_beyond():
    bearing = TABLED.bearings[0]
    for row in SOFTENING:
        stiffness, damping, _ = bearing.at(row.speed)
        np.testing.assert_allclose(stiffness, row.stiffness, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(damping, row.damping, rtol=1e-12, atol=1e-9)
    for beyond, last in ((500.0, 400.0), (-50.0, 0.0)):
        np.testing.assert_array_equal(bearing.at(beyond)[0], bearing.at(last)[0])


def test_two_speeds_are_interpolated_linearly():
    bearing = Bearing("a", 1, at_speed=tuple(AtSpeed(s, tensor(1e6 + s), tensor(1e3)) for s in (0.0, 400.0)))
    assert bearing.at(130.0)[0][0, 0] == pytest.approx(1e6 + 130.0, rel=1e-12)


def test_smooth_table_is_interpolated_to_third_order():
    """Monotone interpolation of exp(Omega/200) with half the distance between speeds has an eighth of the error."""

    def error(count):
        speeds = np.linspace(0.0, 400.0, count)
        bearing = Bearing("a", 1, at_speed=tuple(AtSpeed(s, tensor(np.exp(s / 200.0))) for s in speeds.tolist()))
        return max(abs(bearing.at(s)[0][0, 0] - np.exp(s / 200.0)) for s in np.linspace(150.0, 250.0, 101))

    assert error(9) < 2e-3
    assert error(17) < error(9) / 6.0


@pytest.mark.parametrize("damping", [LIFT_OFF, LIFT_OFF[::-1], (1.0, 1e4, 1.0, 1e4, 1.0, 1e4)])
def test_coefficient_stays_between_those_of_neighbouring_speeds(damping):
    """A cubic spline through the damping of gas bearings that lift off is negative at 450 rad/s."""
    speeds = np.arange(100.0, 601.0, 100.0)
    rows = tuple(AtSpeed(s, tensor(1e7), tensor(c)) for s, c in zip(speeds.tolist(), damping, strict=True))
    bearing = Bearing("a", 1, at_speed=rows)
    for (low, c), (high, after) in pairwise(zip(speeds, damping, strict=True)):
        between = [bearing.at(Omega)[1][0, 0] for Omega in np.linspace(low, high, 21)]
        assert min(c, after) - 1e-9 <= min(between)
        assert max(between) <= max(c, after) + 1e-9


def test_positive_damping_of_a_table_damps_between_its_speeds():
    """The ratio of 0.0090 is that of bearings with 500 N s/m at all speeds."""
    rows = tuple(AtSpeed(s, tensor(1e7), tensor(c)) for s, c in zip(range(100, 601, 100), LIFT_OFF, strict=True))
    constant, tabled = (
        modes(supported_rotor(disc_between(Bearing("a", 1, **table), Bearing("b", 3, **table))).model, 450.0, 4)
        for table in ({"stiffness": tensor(1e7), "damping": tensor(500.0)}, {"at_speed": rows})
    )
    for one, other in zip(constant, tabled, strict=True):
        assert one.damping_ratio > 0.0
        assert other.eigenvalue == pytest.approx(one.eigenvalue, rel=1e-9)


@pytest.mark.parametrize("planes", [None, RIG.masters], ids=["full", "condensed"])
@pytest.mark.parametrize("Omega", [60.0, 250.0, 600.0])
def test_analyses_at_a_speed_have_the_bearings_of_that_speed(planes, Omega):
    tabled, held = (supported_rotor(rotor, planes=planes) for rotor in (TABLED, held_at(Omega)))
    result, exact = (np.array([mode.eigenvalue for mode in modes(s.model, Omega, 6)]) for s in (tabled, held))
    np.testing.assert_allclose(result, exact, rtol=1e-9)
    result, exact = (unbalance_response(s, {1: 1e-3}, np.array([Omega]), (4, 11)) for s in (tabled, held))
    np.testing.assert_allclose(result, exact, rtol=1e-12)


def test_critical_speed_uses_the_bearings_of_that_speed():
    crossings = [c for c in campbell(supported_rotor(TABLED).model, np.linspace(0.0, 300.0, 40)).critical_speeds]
    assert crossings
    for critical in crossings:
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
def test_an_invalid_table_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        Bearing("a", 1, **changes)
