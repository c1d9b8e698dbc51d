"""The study of readings: its statements, measures and misfit, and the fit of the rig's unbalance."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from amb_cosim import studies
from amb_cosim.cli import main
from amb_cosim.cosim.signals import SignalTable, Variable
from amb_cosim.cosim.values import quantity
from amb_cosim.places import ATTRIBUTE as PLACES
from amb_cosim.places import Places
from amb_cosim.scenario import load_scenario
from amb_cosim.studies import reading_cases, reading_measures, thesis_readings, unbalance_fit
from amb_cosim.studies.reading_cases import GIVEN, Case, Finding, Reading, read_file, with_rotor
from amb_cosim.studies.reading_measures import MEASURES, misfit
from rotor_analysis.rotor_file import load_rotor

STATEMENTS, READINGS = read_file()
RIG = Places({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2"))


def test_every_statement_has_one_thing_to_say_of_a_scenario() -> None:
    for statement in STATEMENTS:
        kind, stated = statement.stated
        assert isinstance(stated, str) == (kind == "is")
        assert statement.measure.split()[0] in MEASURES.keys() | GIVEN.keys()
        assert load_scenario(statement.scenario).source.startswith("thesis Fig")
    assert {statement.chapter for statement in STATEMENTS} == set(thesis_readings.CHAPTERS)


def test_readings_name_scenarios_and_begin_with_the_scenarios_as_they_are() -> None:
    for chapter in thesis_readings.CHAPTERS:
        first, *others = [reading for reading in READINGS if reading.chapter == chapter]
        assert first == Reading(chapter=chapter, name=first.name)
        assert len({reading.name for reading in others}) == len(others)
        for reading in others:
            assert reading != first.model_copy(update={"name": reading.name})
            for instead in reading.scenarios.values():
                load_scenario(instead)


@pytest.mark.parametrize(
    ("found", "stated", "kind", "expected"),
    [
        (2.0, 1.0, "value", math.log(2.0)),
        (0.5, 1.0, "value", math.log(2.0)),
        (0.5, 1.0, "at_most", 0.0),
        (2.0, 1.0, "at_most", math.log(2.0)),
        (2.0, 1.0, "at_least", 0.0),
        (0.5, 1.0, "at_least", math.log(2.0)),
        (1e6, 1.0, "value", math.log(10.0)),
        (None, 1.0, "at_most", math.log(10.0)),
        (0.0, 1.0, "at_most", 0.0),
        (0.0, 1.0, "value", math.log(10.0)),
        ("rb1", "rb1", "is", 0.0),
        ("rb2", "rb1", "is", 1.0),
        (None, "rb1", "is", 1.0),
    ],
)
def test_misfit_counts_factors_and_outcomes(found: object, stated: object, kind: str, expected: float) -> None:
    assert misfit(found, stated, kind) == pytest.approx(expected)


def signals(rb1: list[int], rb2: list[int]) -> SignalTable:
    """A signal table of ten cycles of ten samples each: modes by cycle, a step at cycle 2, a removal at 8."""
    cycle = np.arange(100) / 10.0
    values: dict[str, np.ndarray] = {}
    for site, modes in (("rb1", rb1), ("rb2", rb2)):
        values[f"rotor_contact.{site}.mode"] = np.repeat(modes, 10)
        values[f"rotor_contact.{site}.f_n"] = 100.0 * np.repeat(modes, 10)
    values["rotor_contact.contact_state"] = np.repeat((np.array(rb1) > 0) + 2 * (np.array(rb2) > 0), 10)
    coordinates = {"time": Variable(cycle, {}), "cycle": Variable(cycle, {})}
    attributes = {"step_cycle": 2.0, "removal_cycle": 8.0, PLACES: json.dumps(asdict(RIG))}
    return SignalTable({name: Variable(v, {}) for name, v in values.items()}, coordinates, attributes)


def test_measures_tell_which_retainers_are_touched_when_and_for_how_long() -> None:
    run = signals(rb1=[0, 0, 0, 1, 1, 0, 1, 0, 1, 0], rb2=[0, 0, 0, 0, 1, 1, 1, 0, 0, 0])
    expected = {
        "first_site": "rb1",
        "touched": "both",
        "touched_after": 1.0,
        "joined_after": 1.0,
        "together": 2.0,
        "after_removal": 0.9,
        "duration": 5.9,
        "share rb2": 3.0 / 4.0,
        "peak rb1": 100.0,
        "settled rb1": 0.0,
        "states": "1",
        "rolls_after": None,
    }
    for measure, value in expected.items():
        name, *arguments = measure.split()
        found = MEASURES[name](run, *arguments)
        assert found == (value if not isinstance(value, float) else pytest.approx(value)), measure


def test_measures_of_a_run_without_contact() -> None:
    run = signals(rb1=[0] * 10, rb2=[0] * 10)
    assert (reading_measures.first_site(run), reading_measures.touched(run)) == (None, "none")
    assert (reading_measures.joined_after(run), reading_measures.duration(run)) == (None, None)
    assert reading_measures.share(run, "rb1") == 0.0


def test_a_reading_changes_the_rotor_file_of_its_scenario(tmp_path: Path) -> None:
    planes = Reading(chapter=4, name="four planes", rotor={"reduction": {"masters": [1, 4, 11, 13]}})
    case = with_rotor(Case(planes, "fig4_9"), tmp_path)
    changed, rig = load_rotor(case.rotor or ""), load_rotor()
    assert changed.reduction.masters == (1, 4, 11, 13)
    assert changed.bodies == rig.bodies
    plain = Case(Reading(chapter=4, name="plain"), "fig4_9")
    assert with_rotor(plain, tmp_path) is plain


def test_gains_of_a_reading_reach_bearings_without_a_controller() -> None:
    given = {"rolac_controller.*.k_b_?": "0.7e6 N/m", "rotor_contact.rb?.mu": 0.1}
    assert reading_cases.settings_for("levitated", given) == given
    assert reading_cases.settings_for("passive", given) == {
        "rotor_contact.mb?.k_b": "0.7e6 N/m",
        "rotor_contact.rb?.mu": 0.1,
    }


def test_the_result_counts_what_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run of chapter 6 is replaced by one that meets all but the statement of the bushes."""

    def found(case: Case) -> list[Finding]:
        statements = reading_cases.of_scenario(reading_cases.statements_of(6), case.scenario)
        return [Finding("as stated", 0.0) if s.counted else Finding(3.0, 1.0) for s in statements]

    monkeypatch.setattr(thesis_readings, "simulate_in_processes", lambda _, cases, __: [found(case) for case in cases])
    monkeypatch.setattr(thesis_readings, "prepare_case", lambda _: None)
    result = studies.readings("6")
    counted = [statement for statement in reading_cases.statements_of(6) if statement.counted]
    assert set(result.misfit["6"].values()) == {0.0}
    assert set(result.met["6"].values()) == {len(counted)}
    assert len(result.rows["6"]) == len(counted) + 3
    text = str(result)
    assert "fig6_13: ends (not counted)" in text
    assert f"met of {len(counted)}" in text
    assert result.figure() is not None


@pytest.mark.parametrize("chapters", ["3", "4,7", "four"])
def test_only_chapters_4_to_6_have_readings(chapters: str) -> None:
    refused = CliRunner().invoke(main, ["study", "readings", "--chapters", chapters])
    assert refused.exit_code == 2
    assert "4, 5 or 6" in refused.output


def test_the_fit_finds_the_unbalances_that_amplitudes_come_from() -> None:
    """Two discs are found to the last digits from six amplitudes, angles relative to the first disc."""
    rng = np.random.default_rng(3)
    responses = rng.normal(size=(6, 4)) + 1j * rng.normal(size=(6, 4))
    u = np.array([0.0, 7e-3, 9e-3 * np.exp(-0.7j), 0.0])
    measured = [unbalance_fit.Amplitude("", "", "", 1e3 * abs(row @ u)) for row in responses]
    fit = unbalance_fit.fit_unbalances(responses, (1, 2), measured)
    assert fit.discs == ("d2", "d3")
    assert fit.unbalance == pytest.approx((7e-3, 9e-3), rel=1e-6)
    assert abs(fit.angle[1]) == pytest.approx(0.7, rel=1e-6)
    assert fit.error < 1e-7
    wrong = unbalance_fit.fit_unbalances(responses, (0, 3), measured)
    assert wrong.error > 0.1


@pytest.mark.slow
def test_the_rig_is_run_with_the_unbalances_that_fit_best() -> None:
    """Scenarios of chapter 6 have what the study finds, to two digits."""
    found = studies.rig_unbalance().best_pair
    given = load_scenario("fig6_6").inputs["rotor_contact"]
    assert found.discs == ("d2", "d3")
    for disc, unbalance in zip(found.discs, found.unbalance, strict=True):
        assert quantity(given[f"{disc}.u"], "kg.m", disc) == pytest.approx(unbalance, abs=0.1e-3)
    assert quantity(given["d3.phi"], "deg", "phi") == pytest.approx(math.degrees(found.angle[1]), abs=1.0)
