"""Stored robustness of the outcomes of packs: complete, correct, and stated with each outcome."""

import re
from pathlib import Path

import pytest

import amb_cosim
from amb_cosim.scenario.scenario import load_scenario
from amb_files.packs import packs
from amb_sweeps.stored_robustness import StoredOutcome, load_robustness, stored_outcomes, write_robustness
from source_check.robustness_runs import outcome_cases, outcome_of_case
from tests.support.messages import raises_naming

ROOT = Path(__file__).parents[2]
PACKS = ("bath_thesis", "rotor_literature")
RUN = (
    *("fig4_15", "fig5_5", "nelson_mcvaugh_rub", "compressor_levitated_touchdown"),
    *("fig4_9", "fig4_14", "fig4_20", "fig4_9_newton", "fig5_6", "fig6_13_opposed", "fig6_15", "relevitation"),
)
# Runs of the thesis whose outcomes a gate can afford, and the others; test_touchdown.py runs those without power.
IN_GATE = (
    *("fig4_5", "fig4_5_d2", "fig4_9", "fig4_12", "fig4_14", "fig5_5", "fig5_5_pid", "fig5_6", "fig5_6_pid"),
    *("fig6_13", "fig6_13_pid", "fig6_18_pid", "rolling_90"),
)
LATER = sorted(name for name in stored_outcomes() if re.match("fig|rol|run", name) and name not in IN_GATE)


@pytest.fixture(scope="module")
def cases():
    return {case.name: case for pack in PACKS for case in outcome_cases(pack)}


def test_every_run_of_a_pack_has_a_robustness_verdict(cases):
    assert cases.keys() == stored_outcomes().keys()


def test_scenarios_and_pages_call_exactly_the_fragile_runs_fragile(cases):
    page = (ROOT / "docs/validation/scenarios.md").read_text(encoding="utf-8")
    scenarios = {name for name, case in cases.items() if case.name == case.scenario.name and not case.settings}
    for name in scenarios & stored_outcomes().keys():
        is_fragile = bool(stored_outcomes()[name].flips)
        assert ("fragile" in load_scenario(name).description) is is_fragile, name
        if is_fragile:
            rows = [line for line in page.splitlines() if line.startswith("|") and re.search(rf"`{name}`", line)]
            assert rows
            assert all("fragile" in row for row in rows)


def outcome_words(outcome, summary):
    """The words for how a run ended, and the sites that it touched."""
    touched = {site for site, force in summary.peak_contact_force.items() if force > 0.0}
    word, has_rolled = summary.recovery or outcome.status, summary.rolling_from is not None
    return {word, *(["rolling"] if has_rolled and word != "rolled" else []), *touched}


@pytest.mark.parametrize("name", [*IN_GATE, *(pytest.param(name, marks=pytest.mark.slow) for name in LATER)])
def test_a_run_ends_as_its_pack_states_and_balances_its_energy(cases, name):
    result = amb_cosim.run(cases[name].scenario, set=cases[name].settings, progress=False)
    assert outcome_words(result.outcome, result.summary) == {*re.findall(r"\w+", stored_outcomes()[name].outcome)} - {
        "touching"
    }
    # They roll under 1000 kN, have modes faster than the steps, or take little net work through many speeds of a grid.
    limits = {"fig4_20": 1e-5, "planes13": 1e-4, "run_up_rolac": 2e-6}
    limit = next((of for part, of in limits.items() if name.startswith(part) or name.endswith(part)), 1e-6)
    assert result.summary.energy_balance < limit


@pytest.mark.slow
@pytest.mark.parametrize("name", RUN)
def test_stored_outcomes_are_those_of_runs(cases, name):
    assert outcome_of_case(cases[name]) == stored_outcomes()[name]


def test_written_verdicts_extend_the_stored_ones(monkeypatch, tmp_path):
    monkeypatch.setattr("amb_sweeps.stored_robustness.packs", lambda: {"mine": tmp_path})
    load_robustness.cache_clear()
    first = {"b": StoredOutcome(outcome="trapped", flips={"C_b - 1 %": "recovered, touching seal"})}
    second = {"a": StoredOutcome(outcome="prevented")}
    write_robustness("mine", first)
    write_robustness("mine", second)
    assert dict(load_robustness("mine")) == first | second
    assert load_robustness("mine")["b"].text == "fragile (C_b - 1 %: recovered, touching seal)"
    load_robustness.cache_clear()


def test_unknown_pack_or_run_is_refused():
    with raises_naming(ValueError, "'bath'", "bath_thesis"):
        outcome_cases("bath")
    with raises_naming(ValueError, "only", "fig4_99"):
        outcome_cases("bath_thesis", ("fig4_99",))
    assert set(PACKS) <= packs().keys()


def test_events_of_packs_are_named_after_what_happens(cases):
    """An engineer reads in a figure that power is lost, not that there is a step."""
    unnamed = [
        (name, event.label)
        for name, case in cases.items()
        for event in case.scenario.event
        if event.label in ("step", "removal") and not {"rotor_contact"} >= {*event.set}
    ]
    assert unnamed == []
