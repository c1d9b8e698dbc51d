"""The report of a few statements: kept answers, failures, page, table and command."""

import json
import re

import pytest
from click.testing import CliRunner
from lxml import html

from amb_cosim.commands.cli import main
from amb_sweeps.stored_robustness import StoredOutcome
from source_check import sources
from source_check.evaluation import Report, assess, judged
from source_check.page import page
from source_check.statements import parse_statements
from source_check.table import markdown
from source_check.verdict import Verdict
from tests.support.messages import assert_names

HERE = {"where": "Fig. 4.9", "source": "run"}
STATEMENTS = {
    "title": "A few",
    "label": "thesis",
    "chapter": [
        {"key": "ch2", "name": "chapter 2", "groups": ["*2_*"]},
        {"key": "ch4", "name": "chapter 4", "title": "Contact", "groups": ["*4_*"]},
    ],
    "sources": {
        "run": {"scenario": "fig4_9", "end_cycle": 6.0},
        "finer": {"scenario": "fig4_9", "end_cycle": 6.0, "rotor_file": "bath_rig"},
        "broken": {"scenario": "fig4_9", "set": {"rotor_contact.no_such": 1.0}},
        "inputs": {"study": "model_inputs"},
    },
    "statement": [
        {"key": "fig4_9.site", "what": "touched first", "value": "RB1", "quantity": "first_site", **HERE},
        {
            **{"key": "fig4_9.force", "what": "force <RB1>", "value": 1e6, "unit": "kN", "why": "a made-up number"},
            **{"quantity": "peak_force", "arguments": {"site": "rb1"}, "converged": "finer", **HERE},
        },
        {
            **{"key": "fig4_9.broken", "what": "of a run that cannot be", "value": 1.0},
            **{"quantity": "peak_force", "arguments": {"site": "rb1"}, **HERE, "source": "broken"},
        },
        {
            **{"key": "table2_2.turns", "where": "Table 2.2", "what": "turns", "value": 158.0, "given": True},
            **{"source": "inputs", "quantity": "parameter"},
            "arguments": {"component": "amb_actuator", "name": "mb1.turns_x"},
        },
        {"key": "fig2_1.sketch", "where": "Fig. 2.1", "what": "layout", "picture": "a sketch"},
    ],
}


@pytest.fixture(scope="module")
def few():
    return parse_statements(STATEMENTS, "few")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def report(few, folder):
    return assess(few, folder, processes=1)


def test_each_statement_has_the_expected_verdict(report):
    assert {item.statement.key: item.verdict for item in report.judged} == {
        "fig4_9.site": Verdict.REPRODUCED,
        "fig4_9.force": Verdict.MISSED,
        "fig4_9.broken": Verdict.NOT_COMPUTED,
        "table2_2.turns": Verdict.GIVEN,
        "fig2_1.sketch": Verdict.PICTURE,
    }


def test_a_failed_run_is_reported_and_the_others_continue(report):
    assert "no_such" in report.failures["broken"]
    assert "no_such" in next(item.reason for item in report.judged if item.statement.key == "fig4_9.broken")


def test_a_force_is_judged_on_the_converged_model(report):
    """The rotor's modes beyond those of six planes take part in an impact: a different force, in a separate column."""
    force = next(item for item in report.judged if item.statement.key == "fig4_9.force")
    assert force.converged_is_met is False
    assert abs(force.converged / force.ours - 1.0) > 0.002
    assert f"{force.converged:.4g} kN, not met" in markdown(report)


def test_an_outcome_is_listed_with_its_robustness(few, report):
    """Texts and booleans are outcomes; a number has a tolerance."""
    fragile = StoredOutcome(outcome="recovered", flips={"K_b + 1 %": "trapped"})
    robustness = {"run": fragile, "inputs": fragile}
    again = [judged(item.statement, few, report.answers, robustness) for item in report.judged]
    reported = {item.statement.key: item.robustness for item in again if item.robustness}
    assert reported == {"fig4_9.site": "fragile (K_b + 1 %: trapped)"}
    assert "ragile (K_b + 1 %: trapped)" in markdown(Report(few, tuple(again), report.answers))


def test_stored_answers_are_reused(few, folder, report, monkeypatch):
    monkeypatch.setattr(sources, "simulate_in_processes", lambda *_, **__: pytest.fail("ran again"))
    again = assess(few, folder)
    assert [item.ours for item in again.judged] == [item.ours for item in report.judged]


def test_an_answer_to_other_code_is_not_used(few, folder, report, monkeypatch):
    simulated = []
    monkeypatch.setattr("source_check.evaluation.code_digest", lambda: "other code")
    monkeypatch.setattr(sources, "simulate_in_processes", lambda _, jobs, *__, **___: simulated.extend(jobs))
    assess(few, folder)
    assert {job.name for job in simulated} == {"run", "finer", "broken", "inputs"}


def test_a_truncated_answer_is_recomputed(few, folder, report, monkeypatch):
    simulated = []
    file = folder / "sources" / "inputs.json"
    text = file.read_text(encoding="utf-8")
    file.write_text(text[: len(text) // 2], encoding="utf-8")

    def work(_, jobs, *__, **___):
        simulated.extend(job.name for job in jobs)
        file.write_text(text, encoding="utf-8")

    monkeypatch.setattr(sources, "simulate_in_processes", work)
    assess(few, folder)
    assert simulated == ["inputs"]


def test_the_page_shows_every_statement_and_needs_no_network(report):
    text = page(report)
    tree = html.fromstring(text)
    rows = {row.get("id"): row for row in tree.iter("tr")}
    for item in report.judged:
        assert item.statement.what in rows[item.statement.key].text_content()
        assert item.verdict.value in rows[item.statement.key].text_content()
    loaded = [*tree.xpath("//@src"), *tree.xpath("//link/@href")]
    assert [place for place in loaded if not place.startswith("data:")] == []
    assert "<RB1>" not in re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)


def test_the_table_has_a_row_for_each_statement(report):
    lines = markdown(report).splitlines()
    assert sum(line.startswith(("| Fig.", "| Table")) for line in lines) == len(report.judged)
    assert any("1e+06 kN" in line and "A made-up number" in line for line in lines)


def test_the_command_refuses_unknown_names(tmp_path):
    result = CliRunner().invoke(main, ["report", "--only", "ch9", "-o", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert_names(result.output, "only = ", "ch9")
    assert not (tmp_path / "out").exists() or not any((tmp_path / "out").iterdir())


@pytest.mark.slow
@pytest.mark.gate
def test_the_command_writes_page_and_data(tmp_path):
    result = CliRunner().invoke(main, ["report", "--only", "eq4_30", "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "   1 follows from the definition\n" in result.output
    (row,) = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["statements"]
    assert row["ours"] == pytest.approx(100.0 / 3.0)
    assert "<h1>" in (tmp_path / "report.html").read_text(encoding="utf-8")
