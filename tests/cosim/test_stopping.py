"""The point at which a condition on a signal is met, and its form in a scenario."""

import math

import numpy as np

from amb_cosim.cosim.system.stopping import Condition, StopObserver, Stopped


def first_met(values, *conditions, start=0):
    """Index and point at which the first of the conditions (side, limit, first, hold) is met by the values, or None."""
    observer = StopObserver(
        [Condition("x", side == "above", limit, first, hold, "") for side, limit, first, hold in conditions],
        [0] * len(conditions),
    )
    try:
        for n, value in enumerate(values, start):
            observer(n, np.array([value]))
    except Stopped as stopped:
        return stopped.index, stopped.point
    return None


def test_a_limit_itself_is_neither_above_nor_below():
    assert first_met([1.0, 1.0], ("above", 1.0, 0, 0)) is None
    assert first_met([1.0, 1.0], ("below", 1.0, 0, 0)) is None
    assert first_met([1.0, np.nextafter(1.0, 2.0)], ("above", 1.0, 0, 0)) == (0, 1)
    assert first_met([1.0, np.nextafter(1.0, 0.0)], ("below", 1.0, 0, 0)) == (0, 1)


def test_negative_limits_are_not_mirrored():
    assert first_met([-3.0, -1.0, 5.0], ("above", -2.0, 0, 0)) == (0, 1)
    assert first_met([-1.0, 5.0, -3.0], ("below", -2.0, 0, 0)) == (0, 2)


def test_an_interruption_restarts_the_hold_time():
    assert first_met([2, 2, 2, 0, 2, 2, 2, 2, 2], ("above", 1.0, 0, 3)) == (0, 7)
    assert first_met([2, 2, 2, 0, 2, 2, 2], ("above", 1.0, 0, 3)) is None


def test_points_before_the_first_do_not_count_for_the_hold():
    assert first_met([2.0] * 20, ("above", 1.0, 5, 3)) == (0, 8)
    assert first_met([2.0] * 30, ("above", 1.0, 0, 3), start=-10) == (0, 3)
    assert first_met([0, 0, 0, 0, 0, 0, 2, 2, 2, 2], ("above", 1.0, 5, 3)) == (0, 9)


def test_nan_exceeds_no_limit():
    assert first_met([math.nan] * 3, ("above", 1.0, 0, 0), ("below", 1.0, 0, 0)) is None
    assert first_met([2.0, math.nan, 2.0, 2.0], ("above", 1.0, 0, 1)) == (0, 3)


def test_the_first_of_several_met_conditions_ends_the_run():
    assert first_met([0.0, 3.0, -3.0], ("below", -2.0, 0, 0), ("above", 2.0, 0, 0)) == (1, 1)
    assert first_met([3.0], ("above", 2.0, 0, 0), ("above", 1.0, 0, 0)) == (0, 0)
