"""Differences of angles across the end of a turn, in a comparison of runs and in a verification."""

import math

import numpy as np
import pytest

from amb_cosim.cosim.record.differences import differences
from amb_cosim.cosim.verify.verification_process import _largest_deviation

TIMES = np.linspace(0.0, 1.0, 9)
ANGLE = (2.0 * math.pi * 2.0 * TIMES) % (2.0 * math.pi)  # 0 at each whole turn
EARLIER = (2.0 * math.pi * 2.0 * TIMES - 1e-9) % (2.0 * math.pi)  # 2 pi - 1e-9 there


@pytest.mark.parametrize("shift", [0.0, math.pi])
def test_angles_beside_the_end_of_a_turn_are_neighbours(shift):
    assert differences(EARLIER - shift, ANGLE - shift, "rad") == pytest.approx(1e-9, rel=1e-6)


def test_angles_in_degrees_are_neighbours_too():
    assert differences(np.degrees(EARLIER), np.degrees(ANGLE), "deg") == pytest.approx(np.degrees(1e-9), rel=1e-5)


def test_other_signals_and_angles_of_many_turns_do_not_start_again():
    assert differences(EARLIER, ANGLE, "m").max() == pytest.approx(2.0 * math.pi)
    many = 10.0 * ANGLE
    assert differences(many + 2.0 * math.pi, many, "rad") == pytest.approx(2.0 * math.pi)


@pytest.mark.parametrize(("unit", "least", "most"), [("rad", 0.0, 1e-8), (None, 0.5, 2.0)])
def test_an_angle_that_starts_again_a_last_bit_later_is_verified(unit, least, most):
    found = _largest_deviation(TIMES, {"theta": ANGLE[:, None]}, {"time": TIMES, "theta": EARLIER}, {"theta": unit})
    assert least < found.relative < most
