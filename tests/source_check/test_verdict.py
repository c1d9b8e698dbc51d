"""Verdicts: from value, tolerance and reading alone."""

import pytest

from source_check.verdict import Verdict, judge, meets, ratios


@pytest.mark.parametrize(
    ("fields", "ours", "is_met"),
    [
        ({"value": 10.0, "tolerance": 0.1}, 11.0, True),
        ({"value": 10.0, "tolerance": 0.1}, 11.01, False),
        ({"value": 10.0, "tolerance": 0.1}, 8.99, False),
        ({"value": -10.0, "tolerance": 0.1}, -9.0, True),
        ({"value": 0.0, "absolute": 0.5}, -0.5, True),
        ({"value": 0.1, "tolerance": 0.1, "absolute": 0.05}, 0.15, True),
        ({"value": 1.0, "relation": "below"}, 0.2, True),
        ({"value": 1.0, "relation": "below"}, 1.01, False),
        ({"value": 1.0, "relation": "below", "floor": 0.5}, 0.5, True),
        ({"value": 1.0, "relation": "below", "floor": 0.5}, 0.49, False),
        ({"value": 1.0, "relation": "above"}, 0.99, False),
        ({"value": (1.0, 2.0), "tolerance": 0.1}, [1.05, 1.9], True),
        ({"value": (1.0, 2.0), "tolerance": 0.1}, [1.05, 1.7], False),
        ({"value": (1.0, 2.0), "tolerance": 0.1}, [1.0], False),
        ({"value": "RB1"}, "RB1", True),
        ({"value": "RB1"}, "RB1 and RB2", False),
        ({"value": True}, 1.0, False),
        ({"value": 1.0, "tolerance": 0.1}, float("nan"), False),
        ({"value": 1.0}, None, False),
    ],
)
def test_a_value_is_within_its_tolerance_or_not(statement, fields, ours, is_met):
    assert meets(statement(**fields), ours) is is_met


def test_a_value_that_needs_a_reading_is_not_plainly_reproduced(statement):
    assert judge(statement(value=1.0), [(1.0, "times 1.4")]) == (Verdict.WITH_READING, 0)
    assert judge(statement(value=1.0), [(1.0, "")]) == (Verdict.REPRODUCED, 0)


def test_a_second_reading_counts_if_the_first_misses(statement):
    assert judge(statement(value=1.0), [(2.0, ""), (1.0, "on D2")]) == (Verdict.WITH_READING, 1)


def test_a_miss_is_judged_by_the_first_reading(statement):
    assert judge(statement(value=1.0), [(2.0, ""), (3.0, "on D2")]) == (Verdict.MISSED, 0)


def test_a_deviating_input_is_missed(statement):
    assert judge(statement(value=1.0, given=True), [(1.0, "")])[0] is Verdict.GIVEN
    assert judge(statement(value=1.0, given=True), [(2.0, "")])[0] is Verdict.MISSED


def test_a_statement_without_a_value_is_not_computed(statement):
    assert judge(statement(value=1.0), [(None, "")])[0] is Verdict.NOT_COMPUTED
    assert judge(statement(quantity="", missing="no study"), [])[0] is Verdict.NOT_COMPUTED
    assert judge(statement(quantity="", picture="a sketch"), [])[0] is Verdict.PICTURE


def test_ratios_are_those_of_each_number(statement):
    assert ratios(statement(value=(1.0, 0.0, 4.0)), [2.0, 1.0, 2.0]) == (2.0, 0.5)
    assert ratios(statement(value=1.0, relation="below"), 0.5) == ()


def test_a_definition_does_not_count_as_reproduced(statement):
    assert judge(statement(value=1.0, definition=True), [(1.0, "on D2")])[0] is Verdict.DEFINITION
    assert judge(statement(value=1.0, definition=True), [(2.0, "")])[0] is Verdict.MISSED


def test_a_value_within_a_limit_is_reported_as_such(statement):
    below = statement(value=1.0, relation="below")
    assert judge(below, [(0.1, "")])[0] is Verdict.WITHIN_LIMIT
    assert judge(below, [(0.1, "on D2")])[0] is Verdict.WITHIN_LIMIT
    assert judge(below, [(2.0, "")])[0] is Verdict.MISSED
