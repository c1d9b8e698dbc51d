"""Rows of several steps: what a communication step of their length would have, however the values arrive."""

import numpy as np
import pytest

from amb_cosim.cosim.record.step_rows import MOST_ROWS, StepRows, complete_rows, steps_in_row

RULES = ("end", "largest", "sum", "mean")
VALUES = np.random.default_rng(5).normal(size=(1000, len(RULES)))


def rows_of(first, steps, parts):
    rows = StepRows(first, RULES, steps)
    at = 0
    for size in parts:
        rows.add(VALUES[at : at + size])
        at += size
    return rows


@pytest.mark.parametrize("first", [-7, 0, 1, 5])
@pytest.mark.parametrize("steps", [1, 2, 5, 10])
def test_a_row_has_end_largest_sum_and_mean_of_its_steps(first, steps):
    rows = rows_of(first, steps, [997])
    points = first + np.arange(997)
    expected = []
    for end in rows.points:
        of = VALUES[:997][(points <= end) & (-(-points // steps) == -(-end // steps))]
        expected.append([of[-1, 0], of[:, 1].max(), of[:, 2].sum(), of[:, 3].mean()])
    np.testing.assert_allclose(rows.values, expected, rtol=1e-12, atol=1e-12)
    assert (rows.points[:-1] % steps == 0).all()
    assert rows.points[-1] == points[-1]


@pytest.mark.parametrize("steps", [1, 7])
def test_rows_do_not_depend_on_how_their_values_arrive(steps):
    whole = rows_of(3, steps, [600])
    for parts in ([1] * 600, [13] * 46 + [2], [599, 1]):
        other = rows_of(3, steps, parts)
        np.testing.assert_array_equal(other.values, whole.values)
        np.testing.assert_array_equal(other.points, whole.points)


def test_a_continued_record_has_the_same_rows():
    whole, begun, continued = rows_of(3, 7, [600]), rows_of(3, 7, [111]), StepRows(3, RULES, 1)
    continued.restore(3 + 111, begun.complete.copy(), begun.rest.copy(), begun.steps)
    continued.add(VALUES[111:600])
    np.testing.assert_array_equal(continued.values, whole.values)
    np.testing.assert_array_equal(continued.points, whole.points)
    assert complete_rows(3, 114, 7) == (len(begun.complete), len(begun.rest))


def test_a_record_grows_with_the_time_in_place_of_the_steps():
    """Up to MOST_ROWS each step has its row; then rows get longer, end where samples are, and never exceed 0.5 ms."""
    assert steps_in_row(MOST_ROWS, 4000, 50e-6) == 1
    assert steps_in_row(MOST_ROWS + 1, 4000, 50e-6) == 2
    assert steps_in_row(5 * MOST_ROWS, 12, 50e-6) == 6  # a divisor of 12
    assert steps_in_row(1000 * MOST_ROWS, 4000, 50e-6) == 10
    assert steps_in_row(1000 * MOST_ROWS, 4000, 250e-6) == 2
    assert steps_in_row(1000 * MOST_ROWS, 7, 50e-6) == 7
    assert steps_in_row(1000 * MOST_ROWS, 100, 1e-3) == 1
