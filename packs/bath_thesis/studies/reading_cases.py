"""Readings of the thesis's open points, and the run of a source of its statements under one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from pydantic import Field

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.tables import Table, Values
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import run_prepared
from amb_files.toml import parse_toml, validate
from bath_thesis.misfit import misfit
from source_check.quantities import quantities_of_runs
from source_check.requests import QuantityRequest, evaluate
from source_check.source_runs import prepare_source
from source_check.statements import Source, Statement, load_statements
from source_check.verdict import Computed, meets

PACK = "bath_thesis"


class ReadingCase(Table):
    """Changes from the scenarios.

    set
        Values by `component.variable`.
    scenarios
        Scenarios by the name of those that they replace.
    unbalance_factor
        Factor of all unbalances of the scenarios.
    rotor
        Tables that replace those of the rotor file.
    """

    chapter: int
    name: str
    set: Values = Field(default={})
    scenarios: dict[str, str] = Field(default={})
    unbalance_factor: float | None = None
    rotor: dict[str, dict[str, Any]] = Field(default={})


class _File(Table):
    reading: tuple[ReadingCase, ...]


@dataclass(frozen=True)
class Case:
    """A source under a reading, and the statements that it covers."""

    reading: ReadingCase
    name: str
    source: Source
    statements: tuple[Statement, ...]
    flavour: Flavour = "native"


@dataclass(frozen=True)
class ReadingResult:
    """The value of a run for a statement, its misfit, and whether it is within the statement's tolerance."""

    found: Computed | None
    misfit: float
    is_met: bool


def load_readings() -> tuple[ReadingCase, ...]:
    """Return all readings; the first of a chapter is that of the unchanged scenarios."""
    source = files(__package__) / "readings.toml"
    return validate(parse_toml(source.read_text(encoding="utf-8"), "readings"), _File, "readings").reading


def statements_of(chapter: int) -> list[Statement]:
    """Return the statements of a chapter that a run covers."""
    available = load_statements(PACK)
    return [s for s in available.named[f"ch{chapter}"] if s.quantity and available.sources[s.source].scenario]


def cases_of(reading: ReadingCase, flavour: Flavour = "native") -> list[Case]:
    """Return the runs of a reading, one for each source of its chapter's statements."""
    statements, sources = statements_of(reading.chapter), load_statements(PACK).sources
    return [
        Case(
            reading,
            name,
            under(reading, sources[name]),
            tuple(s for s in statements if s.source == name),
            flavour,
        )
        for name in dict.fromkeys(s.source for s in statements)
    ]


def under(reading: ReadingCase, source: Source) -> Source:
    """Return a source under a reading."""
    scenario = reading.scenarios.get(source.scenario, source.scenario)
    return source.model_copy(
        update={
            "scenario": scenario,
            "set": dict(source.set) | settings_for(load_scenario(scenario).system, reading.set),
            "unbalance_factor": reading.unbalance_factor or source.unbalance_factor,
            "rotor": source.rotor | reading.rotor,
        }
    )


def settings_for(system: str, given: Values) -> Values:
    """Return the settings for a system; on passive bearings, gains of the controller become those of the bearings."""
    if system != "passive":
        return given
    gains = {f"rolac_controller.*.{gain}_?": f"rotor_contact.mb?.{gain}" for gain in ("k_b", "c_b")}
    return {gains.get(name, name): value for name, value in given.items()}


def simulate_case(case: Case) -> list[ReadingResult]:
    """Simulate a case and return its finding for each of its statements, in order.

    Raises
    ------
    ValueError
        If it does not reach its end.
    """
    result = run_prepared(prepare_source(case.source, case.flavour))
    if result.outcome.failure is not None:
        raise ValueError(f"{case.name}, {case.reading.name}: {result.outcome.failure}")
    return [_finding(statement, result.signals) for statement in case.statements]


def mean_misfit(findings: Sequence[ReadingResult]) -> float:
    """Return the mean misfit of findings."""
    return sum(finding.misfit for finding in findings) / len(findings)


def _finding(statement: Statement, run: Any) -> ReadingResult:
    request = QuantityRequest(statement.quantity, tuple(statement.arguments.items()), statement.unit)
    result = evaluate(run, request, quantities_of_runs(load_statements(PACK).quantities))
    return ReadingResult(result, misfit(statement, result), meets(statement, result))
