"""Test forces: the thesis's numbers, power and peaks of the multi-sine."""

import math

import numpy as np
import pytest

from rolac_controller.excitation import amplitude_at, force_component, periods, power_share, schroeder_phase
from rolac_controller.records import HARMONIC


@pytest.mark.parametrize(
    ("frequency", "expected"),
    [(0.0, 110.0), (5.0, 220.0 / 3.25), (10.0, 48.9), (16.0, 66.7), (20.0, 88.0), (30.0 - 1e-9, 440.0), (30.0, 550.0)],
)
def test_test_force_matches_the_thesis(frequency, expected):
    assert amplitude_at(frequency) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("frequency", "expected"),
    [(5.0, 45), (15.0, 45), (16.0, 48), (16.0 * (1.0 + 1e-15), 48), (16.1, 49), (35.0, 105)],
)
def test_slot_lasts_three_seconds_or_45_periods(frequency, expected):
    assert periods(frequency) == expected


FOUR = np.array([1.0, 2.0, 3.0, 4.0])


def harmonics_of(powers, orders=FOUR):
    """Four harmonics for the kernels."""
    harmonics = np.zeros(4, dtype=HARMONIC)
    harmonics["order"], harmonics["power"] = orders, powers
    return harmonics


@pytest.mark.parametrize("powers", [FOUR, np.ones(4)])
def test_phases_of_consecutive_harmonics_follow_the_formula_of_the_thesis(powers):
    """phase_i = -2 pi sum_{m < i} (i - m) P_m: of equal powers, the quadratic phases of Schroeder."""
    relative = powers / powers.sum()
    for i in range(4):
        expected = -2.0 * math.pi * sum((i - m) * relative[m] for m in range(i))
        assert schroeder_phase(harmonics_of(powers), i) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("powers", [np.ones(4), np.array([1.0, 0.5, 0.5, 0.2])])
def test_phases_lower_the_peak_of_the_sum(powers):
    turn = np.exp(1j * np.outer(np.linspace(0.0, 2.0 * math.pi, 4001), FOUR))
    forces = np.array([force_component(harmonics_of(powers), k, True, 1.0, 40.0) for k in range(4)])
    peak, in_phase = (np.abs((turn * f).real.sum(axis=1)).max() for f in (forces, np.abs(forces)))
    assert peak < 0.75 * in_phase


def test_power_of_the_sum_is_that_of_a_single_harmonic():
    """Above 30 Hz A is the same for all harmonics."""
    for powers in (np.ones(4), np.array([5.0, 1.0, 0.0, 2.0])):
        forces = [force_component(harmonics_of(powers), k, True, 1.0, 40.0) for k in range(4)]
        assert sum(abs(f) ** 2 for f in forces) == pytest.approx(amplitude_at(40.0) ** 2, rel=1e-12)


def test_amplitude_of_each_harmonic_depends_on_its_frequency():
    forces = [abs(force_component(harmonics_of(1.0), k, True, 1.0, 8.0)) for k in range(4)]
    np.testing.assert_allclose(forces, [amplitude_at(8.0 * n) / 2.0 for n in FOUR], rtol=1e-12)


def test_single_harmonic_has_the_whole_amplitude_and_no_phase():
    assert force_component(harmonics_of(1.0), 0, False, 1.5, 16.0) == 1.5 * amplitude_at(16.0)
    assert force_component(harmonics_of(1.0), 1, False, 1.5, 16.0) == 0.0


def test_unused_harmonics_have_no_amplitude():
    harmonics = harmonics_of(1.0, [1.0, 3.0, 0.0, 0.0])
    assert power_share(harmonics, 1) == 0.5
    assert force_component(harmonics, 2, True, 1.0, 16.0) == 0.0
