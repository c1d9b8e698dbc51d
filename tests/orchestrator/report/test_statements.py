"""The statements that come with the package: complete, well formed, computable."""

from __future__ import annotations

import inspect
import re

import pytest

from amb_cosim.report import study_quantities
from amb_cosim.report.evaluation import reading_of, ways, ways_beside
from amb_cosim.scenario.scenario import packaged_scenarios
from amb_cosim.studies import STUDIES
from amb_cosim.thesis import run_quantities
from amb_cosim.thesis.statements import load_statements, parse_statements, selected

FIGURES = {2: 8, 3: 9, 4: 21, 5: 6, 6: 20}
TABLES = {2: 4, 3: 4}
GOOD = {
    "sources": {"run": {"scenario": "fig4_9"}},
    "statement": [
        {
            "key": "fig4_9.force",
            "where": "Fig. 4.9",
            "what": "force",
            "value": 6.0,
            "source": "run",
            "quantity": "peak_force",
        }
    ],
}


@pytest.fixture(scope="module")
def statements():
    return load_statements()


@pytest.mark.parametrize(("kind", "numbers"), [("Fig.", FIGURES), ("Table", TABLES)])
def test_no_figure_and_no_table_is_left_out(statements, kind, numbers):
    named = {match[1] for s in statements.statement if (match := re.match(rf"{re.escape(kind)} (\d\.\d+)", s.where))}
    expected = {f"{chapter}.{n}" for chapter, count in numbers.items() for n in range(1, count + 1)}
    assert expected - named == set()


def test_every_source_exists_and_is_used(statements):
    used = {s.source for s in statements.statement} | {
        way.source for s in statements.statement for way in (*ways(s, statements), *ways_beside(s, statements))
    }
    assert set(statements.sources) - used == set()
    for source in statements.sources.values():
        assert source.scenario in packaged_scenarios() or source.study in {*STUDIES, "model_inputs"}


def test_every_quantity_exists_and_takes_its_arguments(statements):
    for s in statements.statement:
        for way in (*ways(s, statements), *ways_beside(s, statements)):
            module = run_quantities if statements.sources[way.source].scenario else study_quantities
            function, _ = module.QUANTITIES[way.asked.quantity]
            inspect.signature(function).bind(None, **dict(way.asked.arguments))


def test_a_factor_on_the_unbalances_is_a_reading(statements):
    assert reading_of(statements.sources["fig5_5"])[0] == "all unbalances times 1.44"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quantity": ""}, "needs one of quantity, picture and missing"),
        ({"value": None}, "needs value and source"),
        ({"source": "fun"}, "no source 'fun'; did you mean run"),
        ({"relation": "below", "value": "RB1"}, "relation below needs a number"),
        ({"tolerance": -0.1}, r"tolerance = -0.1 is not allowed; it must be >= 0"),
        ({"where": "Fig. 1.1"}, "where"),
        ({"tolarance": 0.1}, "unknown key statement.0..tolarance; did you mean tolerance"),
    ],
)
def test_a_wrong_statement_is_refused(change, message):
    wrong = {k: v for k, v in (GOOD["statement"][0] | change).items() if v is not None}
    with pytest.raises(ValueError, match=message):
        parse_statements(GOOD | {"statement": [wrong]}, "statements.toml")


def test_two_statements_may_not_share_a_key():
    with pytest.raises(ValueError, match=r"two statements have the key fig4_9\.force"):
        parse_statements(GOOD | {"statement": GOOD["statement"] * 2}, "statements.toml")


def test_a_chapter_and_a_figure_can_be_selected(statements):
    assert {s.chapter for s in selected(statements, ["ch4"])} == {4}
    assert {s.group for s in selected(statements, ["fig4_9", "table3_1"])} == {"fig4_9", "table3_1"}


def test_a_selection_that_is_not_there_is_refused(statements):
    with pytest.raises(ValueError, match=r"--only fig4_99 is not allowed; did you mean fig4_9"):
        selected(statements, ["fig4_99"])
