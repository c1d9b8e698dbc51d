"""Undamped modes at rest: springs, divergence, rigid motion."""

import numpy as np
import pytest
from analysis_cases import I_D, MASS, L, disc_between, natural_frequencies, tensor

from rotor_analysis.modes import damped_frequencies
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.reduced_rotor import reduction_error
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor


def disc_on_springs(stiffness):
    return disc_between(Bearing("a", 1, tensor(stiffness)), Bearing("b", 3, tensor(stiffness)))


@pytest.mark.parametrize("stiffness", [1e3, -1e3])
def test_soft_bearings_carry_a_rigid_disc_or_let_it_diverge(stiffness):
    """k_2 = 2 k over the mass, and k L^2 / 2 over the inertia: both negative on negative stiffness."""
    expected = np.sign(stiffness) * np.sqrt(np.abs([2.0 * stiffness / MASS, 0.5 * stiffness * L**2 / I_D]))
    result = natural_frequencies(disc_on_springs(stiffness), 2)
    np.testing.assert_allclose(np.sort(np.abs(result)), np.sort(np.abs(expected)), rtol=2e-3)
    np.testing.assert_array_equal(np.sign(result), np.sign(expected))


@pytest.mark.parametrize("stiffness", [1e3, -1e3])
def test_the_motion_that_one_spring_holds_or_drives_is_listed(stiffness):
    """omega^2 = k (1/m + (L/2)^2/I_d) of a spring at the end; the disc is free to turn about that end."""
    springs = Bearing("a", 1, tensor(stiffness)), Bearing("b", 3, tensor(0.0))
    (first,) = natural_frequencies(disc_between(*springs), 2)
    expected = np.sqrt(abs(stiffness) * (1.0 / MASS + 0.25 * L**2 / I_D))
    assert first == pytest.approx(np.sign(stiffness) * expected, rel=5e-3)


def test_rigid_motion_is_counted_and_left_out():
    rotor = load_rotor()
    for stiffness, bearings, count in ((1e6, 2, 6), (1e6, 1, 5), (0.0, 2, 4)):
        some = rotor.on_equal_bearings(stiffness, 0.0).bearings[:bearings]
        assert len(natural_frequencies(Rotor(rotor.name, rotor.shaft, rotor.bodies, some), 6)) == count


def test_frequencies_are_those_of_the_full_problem_without_damping():
    rotor = load_rotor().on_equal_bearings(2e6, 0.0)
    full = damped_frequencies(supported_rotor(rotor).model, 0.0, 12)[::2]
    np.testing.assert_allclose(natural_frequencies(rotor, 6), full, rtol=1e-7)


def test_bearing_over_speed_has_the_stiffness_of_its_lowest_speed():
    table = tuple(AtSpeed(speed, tensor(k)) for speed, k in ((0.0, 1e3), (100.0, 9e3)))
    rotor = disc_between(Bearing("a", 1, at_speed=table), Bearing("b", 3, at_speed=table))
    np.testing.assert_allclose(natural_frequencies(rotor, 2), natural_frequencies(disc_on_springs(1e3), 2))


@pytest.mark.parametrize("angle", [0.0, 45.0, 90.0])
def test_unequal_planes_have_frequencies_of_their_own(angle):
    """A disc on springs of 1 and 3 kN/m, along x and y or turned: 2 k/m and k L^2/(2 I_d) for each of them."""
    turn = np.array([[np.cos(np.radians(angle)), -np.sin(np.radians(angle))]] * 2)
    turn[1] = turn[0, ::-1] * (-1.0, 1.0)
    stiffness = (turn @ np.diag([1e3, 3e3]) @ turn.T).tolist()
    rotor = disc_between(Bearing("a", 1, stiffness), Bearing("b", 3, stiffness))
    squares = [(2.0 * k / MASS, 0.5 * k * L**2 / I_D) for k in (1e3, 3e3)]
    expected = np.sqrt(np.sort(np.ravel(squares)))
    np.testing.assert_allclose(reduction_error(rotor, 2).frequencies, expected, rtol=5e-3)


def test_spring_in_a_single_direction_holds_two_motions_of_four():
    """A disc on springs along y that floats along x: no rigid motion is listed, and both springs are."""
    along_y = ((0.0, 0.0), (0.0, 1e3))
    rotor = disc_between(Bearing("a", 1, along_y), Bearing("b", 3, along_y))
    expected = np.sort(np.sqrt([2e3 / MASS, 0.5e3 * L**2 / I_D]))
    np.testing.assert_allclose(reduction_error(rotor, 2).frequencies, expected, rtol=5e-3)
