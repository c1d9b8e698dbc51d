"""The format of statements: invalid ones are refused."""

import pytest

from source_check.statements import load_statements, parse_statements
from tests.support.messages import raises_naming

GOOD = {
    "title": "Good",
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


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        ({"quantity": ""}, ("quantity", "picture", "missing")),
        ({"value": None}, ("value", "source")),
        ({"source": "fun"}, ("'fun'", "run")),
        ({"relation": "below", "value": "RB1"}, ("relation", "below", "number")),
        ({"tolerance": -0.1}, ("tolerance", "-0.1", ">= 0")),
        ({"floor": 1.0}, ("floor", "1", "below")),
        ({"cause": "bad luck"}, ("cause", "data", "reading")),
        ({"where": ""}, ("where",)),
        ({"tolarance": 0.1}, ("statement[0].tolarance", "tolerance")),
    ],
)
def test_an_invalid_statement_is_refused(change, facts):
    wrong = {k: v for k, v in (GOOD["statement"][0] | change).items() if v is not None}
    with raises_naming(ValueError, *facts):
        parse_statements(GOOD | {"statement": [wrong]}, "statements.toml")


def test_two_statements_may_not_share_a_key():
    with raises_naming(ValueError, "fig4_9.force"):
        parse_statements(GOOD | {"statement": GOOD["statement"] * 2}, "statements.toml")


def test_every_statement_is_in_a_chapter():
    with raises_naming(ValueError, "fig4_9.force", "chapter"):
        parse_statements(GOOD | {"chapter": [{"key": "ch5", "name": "chapter 5", "groups": ["*5_*"]}]}, "file")


def test_a_pack_without_statements_is_refused():
    with raises_naming(ValueError, "'bath_theses'", "statements.toml", "bath_thesis"):
        load_statements("bath_theses")
