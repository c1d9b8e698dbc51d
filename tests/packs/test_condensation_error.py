"""Error of the condensation to a few planes, for any planes and any bearings."""

from dataclasses import replace

import numpy as np
import pytest

from bath_thesis.condensation_error import condensation_error
from rotor_analysis.modes import damped_frequencies, modes
from rotor_analysis.rotor import ReductionOptions
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

RIG = load_rotor()
SPEEDS = np.array([90.0, 120.0, 145.0])
CROSS = ((1e6, 4e5), (-6e5, 8e5))  # unsymmetric, as of a journal bearing
ON_OIL = replace(RIG, bearings=tuple(replace(b, stiffness=CROSS) for b in RIG.bearings))
PLANES = [(1, 4, 11, 13), (1, 3, 4, 10, 11, 13), (1, 3, 4, 6, 8, 10, 11, 12, 13), tuple(range(1, 14))]


def worst(error):
    """Return the largest error of a frequency at each speed (percent)."""
    return np.max(np.abs(error.frequency_error), axis=0)


def test_error_of_the_rig_is_that_of_the_frequencies_in_ascending_order():
    """0.1127 % is the largest of the thesis."""
    error = condensation_error(RIG, SPEEDS)
    assert error.planes == RIG.masters
    for row, Omega in zip(error.frequency_error.T, SPEEDS, strict=True):
        full = damped_frequencies(supported_rotor(RIG).model, Omega, 8)
        condensed = damped_frequencies(supported_rotor(RIG, planes=RIG.masters).model, Omega, 8)
        np.testing.assert_allclose(row, 100.0 * (condensed / full - 1.0), atol=1e-9)
    np.testing.assert_allclose(worst(error), [0.089, 0.100, 0.109], atol=6e-4)
    assert np.all(worst(error) < 0.1127)


@pytest.mark.parametrize("rotor", [RIG, ON_OIL], ids=["symmetric", "cross-coupled"])
def test_more_planes_cost_less_accuracy(rotor):
    eigenvalue = [np.max(condensation_error(rotor, SPEEDS, planes, 4).eigenvalue_error) for planes in PLANES]
    assert np.all(np.diff(eigenvalue) < 0.0)
    assert eigenvalue[0] < 1.0
    assert eigenvalue[-1] < 0.05


def test_condensation_keeps_unstable_modes_unstable():
    for planes in PLANES[1:]:
        full, condensed = (modes(supported_rotor(ON_OIL, planes=p).model, 90.0, 8) for p in (None, planes))
        ratios = [[mode.damping_ratio for mode in result] for result in (full, condensed)]
        assert min(ratios[0]) < 0.0
        np.testing.assert_allclose(ratios[1], ratios[0], atol=1e-3)
        assert [mode.whirl for mode in full] == [mode.whirl for mode in condensed]


def test_modes_that_the_condensed_model_does_not_have_are_marked():
    error = condensation_error(RIG, SPEEDS[:1], (4, 11), 8)
    assert np.isnan(error.frequency_error).sum() >= 4  # two planes whirl in four modes


def test_missing_and_unknown_planes_are_refused():
    with raises_naming(ValueError, "node numbers"):
        condensation_error(replace(RIG, reduction=ReductionOptions()), SPEEDS)
    with raises_naming(ValueError, "planes", "[99]", "[1, 2"):
        condensation_error(RIG, SPEEDS, (4, 99))
