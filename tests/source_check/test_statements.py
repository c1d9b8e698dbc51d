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


CHAPTER = {"key": "ch5", "name": "chapter 5", "groups": ["*5_*"]}


def changed(**change):
    """The file with its statement changed, or without a field."""
    return GOOD | {"statement": [{k: v for k, v in (GOOD["statement"][0] | change).items() if v is not None}]}


@pytest.mark.parametrize(
    ("file", "facts"),
    [
        (changed(quantity=""), ("quantity", "picture", "missing")),
        (changed(value=None), ("value", "source")),
        (changed(source="fun"), ("'fun'", "run")),
        (changed(relation="below", value="RB1"), ("relation", "below", "number")),
        (changed(tolerance=-0.1), ("tolerance", "-0.1", ">= 0")),
        (changed(floor=1.0), ("floor", "1", "below")),
        (changed(cause="bad luck"), ("cause", "data", "reading")),
        (changed(where=""), ("where",)),
        (changed(tolarance=0.1), ("statement[0].tolarance", "tolerance")),
        (GOOD | {"statement": GOOD["statement"] * 2}, ("fig4_9.force",)),  # a key twice
        (GOOD | {"chapter": [CHAPTER]}, ("fig4_9.force", "chapter")),  # a statement in no chapter
        ("bath_theses", ("'bath_theses'", "statements.toml", "bath_thesis")),  # a pack without statements
    ],
)
def test_an_invalid_file_of_statements_is_refused(file, facts):
    with raises_naming(ValueError, *facts):
        load_statements(file) if isinstance(file, str) else parse_statements(file, "statements.toml")
