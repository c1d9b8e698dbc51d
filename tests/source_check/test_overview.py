"""The paragraph with which the report and the page on scenarios begin."""

import json
from pathlib import Path

import pytest

from source_check.evaluation import Judged, Report
from source_check.overview import overview
from source_check.statements import load_statements, parse_statements
from source_check.verdict import Verdict

ROOT = Path(__file__).parents[2]
KEYS = ("plain", "read", "kept", "given", "vague", "odd", "picture")
VERDICTS = (
    *(Verdict.REPRODUCED, Verdict.WITH_READING, Verdict.WITHIN_LIMIT, Verdict.GIVEN),
    *(Verdict.MISSED, Verdict.MISSED, Verdict.PICTURE),
)


def report_of(statements, verdicts) -> Report:
    return Report(statements, tuple(Judged(s, verdicts[s.key]) for s in statements.statement), {})


def test_every_statement_is_counted_once_and_misses_by_cause():
    common = {"where": "Fig. 1", "what": "force", "value": 1.0, "source": "run", "quantity": "peak_force"}
    made = [{**common, "key": f"fig1.{key}"} for key in KEYS]
    made[4]["cause"] = "data"
    sources = {"run": {"scenario": "fig4_9"}}
    statements = parse_statements({"title": "few", "label": "paper", "sources": sources, "statement": made}, "few")
    report = report_of(statements, dict(zip((s["key"] for s in made), VERDICTS, strict=True)))
    assert {cause: len(items) for cause, items in report.missed_by_cause().items()} == {
        "data": 1,
        "unexplained": 1,
        "detail": 0,
        "reading": 0,
    }
    text = overview(report)
    for fact in ("paper has 7", "3 of them are reproduced", "2 are not reproduced", "`fig1.odd`"):
        assert fact in text
    assert "fig1.vague" not in text


@pytest.mark.parametrize("chosen", [1, 2, 6])
def test_a_selection_of_statements_is_not_all_that_the_source_has(chosen):
    """The paper has seven statements, also if a report judges fewer of them."""
    common = {"where": "Fig. 1", "what": "force", "value": 1.0, "source": "run", "quantity": "peak_force"}
    made = [{**common, "key": f"fig1.{key}"} for key in KEYS]
    sources = {"run": {"scenario": "fig4_9"}}
    statements = parse_statements({"title": "few", "label": "paper", "sources": sources, "statement": made}, "few")
    items = tuple(Judged(s, v) for s, v in zip(statements.statement[:chosen], VERDICTS, strict=False))
    text = overview(Report(statements, items, {}))
    assert f"{chosen} of the 7 statements" in text
    assert f"paper has {chosen}" not in text
    assert f"{min(chosen, 3)} of them are reproduced" in text


def test_the_page_on_scenarios_begins_with_the_counts_of_the_report():
    """The verdicts are those of the last whole report, which tests/packs/test_known_misses.py repeats."""
    stored = json.loads((ROOT / "tests/regression/known_misses.json").read_text(encoding="utf-8"))
    numbers = stored["test_verdicts_are_unchanged"]["verdicts"]
    statements = load_statements("bath_thesis")
    assert {s.key for s in statements.statement} == numbers.keys()
    report = report_of(statements, {key: [*Verdict][int(number)] for key, number in numbers.items()})
    page = (ROOT / "docs/validation/scenarios.md").read_text(encoding="utf-8")
    assert page.splitlines()[2].startswith(overview(report))
    silent = [s.key for s in statements.statement if s.why == "" and numbers[s.key] == [*Verdict].index(Verdict.MISSED)]
    assert silent == []
