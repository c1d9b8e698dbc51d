"""The study of readings: its statements, measures and misfit, and the fit of the rig's unbalance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from click.testing import CliRunner

from amb_cosim import studies
from amb_cosim.commands.cli import main
from amb_cosim.cosim.system.values import quantity
from amb_cosim.scenario.scenario import load_scenario
from bath_thesis.studies import reading_cases, thesis_readings, unbalance_fit
from bath_thesis.studies.reading_cases import (
    Case,
    ReadingCase,
    ReadingResult,
    cases_of,
    load_readings,
    statements_of,
    under,
)
from bath_thesis.studies.thesis_readings import CHAPTERS
from rotor_analysis.rotor_file import load_rotor
from source_check.source_runs import prepare_source
from source_check.statements import Source
from tests.packs import readings_tables

READINGS = load_readings()


def test_readings_name_scenarios_and_begin_with_the_scenarios_as_they_are() -> None:
    for chapter in CHAPTERS:
        first, *others = [reading for reading in READINGS if reading.chapter == chapter]
        assert first == ReadingCase(chapter=chapter, name=first.name)
        assert len({reading.name for reading in others}) == len(others)
        for reading in others:
            assert reading != first.model_copy(update={"name": reading.name})
            for instead in reading.scenarios.values():
                load_scenario(instead)


def test_a_reading_changes_the_rotor_of_every_source() -> None:
    reading = ReadingCase(chapter=4, name="four planes", rotor={"reduction": {"masters": [1, 4, 11, 13]}})
    source = under(reading, Source(scenario="fig4_9"))
    prepared = prepare_source(source)
    changed, rig = load_rotor(prepared.scenario.rotor), load_rotor()
    assert changed.reduction.masters == (1, 4, 11, 13)
    assert changed.bodies == rig.bodies
    assert under(ReadingCase(chapter=4, name="plain"), Source(scenario="fig4_9")) == Source(scenario="fig4_9")


def test_a_reading_replaces_scenario_values_and_factor() -> None:
    reading = ReadingCase(
        chapter=5, name="x", scenarios={"fig4_16": "fig4_16_opposed"}, set={"a.b": 2}, unbalance_factor=1.9
    )
    values = Source(scenario="fig4_16", set={"a.b": 1, "a.c": 3}, unbalance_factor=1.0)
    assert under(reading, values) == Source(scenario="fig4_16_opposed", set={"a.b": 2, "a.c": 3}, unbalance_factor=1.9)


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_a_reading_is_measured_on_every_statement_of_a_run(chapter: int) -> None:
    cases = cases_of(next(reading for reading in READINGS if reading.chapter == chapter))
    answered = [statement.key for case in cases for statement in case.statements]
    assert sorted(answered) == sorted(statement.key for statement in statements_of(chapter))
    assert len({case.name for case in cases}) == len(cases)


def test_gains_of_a_reading_reach_bearings_without_a_controller() -> None:
    values = {"rolac_controller.*.k_b_?": "0.7e6 N/m", "rotor_contact.rb?.mu": 0.1}
    assert reading_cases.settings_for("levitated", values) == values
    assert reading_cases.settings_for("passive", values) == {
        "rotor_contact.mb?.k_b": "0.7e6 N/m",
        "rotor_contact.rb?.mu": 0.1,
    }


def test_the_misfit_of_a_reading_is_the_mean_over_all_statements(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of chapter 6 are replaced: the first reading meets all, the others err by 1 in one statement of each run."""
    first = next(reading for reading in READINGS if reading.chapter == 6)

    def found(case: Case) -> list[ReadingResult]:
        misses = case.reading != first
        return [
            ReadingResult("as stated", float(misses and k == 0), not misses or k > 0)
            for k in range(len(case.statements))
        ]

    monkeypatch.setattr(thesis_readings, "simulate_in_processes", lambda _, cases, __: [found(case) for case in cases])
    monkeypatch.setattr(thesis_readings, "build_fmus", lambda *_: None)
    result = studies.readings("6")
    runs, count = len(cases_of(first)), len(statements_of(6))
    wanted = {reading.name: 0.0 if reading == first else runs / count for reading in READINGS if reading.chapter == 6}
    assert result.misfit["6"] == pytest.approx(wanted)
    assert set(result.met["6"].values()) == {count, count - runs}
    assert f"met of {count}" in str(result)
    assert studies.figure(result) is not None


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
    result = studies.rig_unbalance().best_pair
    values = load_scenario("fig6_6").inputs["rotor_contact"]
    assert result.discs == ("d2", "d3")
    for disc, unbalance in zip(result.discs, result.unbalance, strict=True):
        assert quantity(values[f"{disc}.u"], "kg.m", disc) == pytest.approx(unbalance, abs=0.1e-3)
    assert quantity(values["d3.phi"], "deg", "phi") == pytest.approx(math.degrees(result.angle[1]), abs=1.0)


def test_tables_on_the_page_have_all_readings_and_all_statements() -> None:
    message = readings_tables.read_page()
    for chapter in CHAPTERS:
        first, *others = [reading.name for reading in READINGS if reading.chapter == chapter]
        expected = {f"**{readings_tables.FIRST}**", *others}
        assert message[int(chapter)] == (len(statements_of(chapter)), expected), f"not of {first} as it is now"
