"""The form of statements: what is wrong is refused."""

from __future__ import annotations

import pytest

from source_check.statements import load_statements, parse_statements

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
    ("change", "message"),
    [
        ({"quantity": ""}, "needs one of quantity, picture and missing"),
        ({"value": None}, "needs value and source"),
        ({"source": "fun"}, "no source 'fun'; did you mean run"),
        ({"relation": "below", "value": "RB1"}, "relation below needs a number"),
        ({"tolerance": -0.1}, r"tolerance = -0.1 is not allowed; it must be >= 0"),
        ({"where": ""}, "where"),
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


def test_every_statement_is_in_a_chapter():
    with pytest.raises(ValueError, match=r"fig4_9\.force: no chapter has groups that match fig4_9"):
        parse_statements(GOOD | {"chapter": [{"key": "ch5", "name": "chapter 5", "groups": ["*5_*"]}]}, "file")


def test_statements_of_a_pack_that_has_none_are_refused():
    with pytest.raises(ValueError, match=r"pack 'bath_theses' has no statements.toml; did you mean bath_thesis"):
        load_statements("bath_theses")
