"""Statements, readings and runs of the study of readings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import Field

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.tables import Table, Values
from amb_cosim.models import CONTROLLER
from amb_cosim.scenario import load_scenario
from amb_cosim.simulation import Prepared, prepare, run_prepared
from amb_cosim.studies.campbell_diagram import campbell
from amb_cosim.studies.convergence_runs import rotor_file
from amb_cosim.studies.reading_measures import MEASURES, Found, misfit
from amb_files.toml import parse_toml, read_toml, validate
from rotor_analysis.packaged_rotors import DEFAULT_ROTOR
from rotor_analysis.rotor_file import load_rotor

Kind = Literal["value", "at_most", "at_least", "is"]
FACTOR = "unbalance_factor"


class Statement(Table):
    """What the thesis states of a figure: one of `value`, `at_most`, `at_least` (in `unit`) and `is_` of a measure.

    One that is not `counted` is shown, and adds nothing to the misfit.
    """

    figure: str
    scenario: str
    measure: str
    value: float | None = None
    at_most: float | None = None
    at_least: float | None = None
    is_: str | None = Field(default=None, alias="is")
    unit: str = ""
    counted: bool = True

    @property
    def chapter(self) -> int:
        """Chapter of the figure."""
        return int(self.figure.partition(".")[0])

    @property
    def stated(self) -> tuple[Kind, float | str]:
        """How the statement is meant, and what it says."""
        wanted = {"value": self.value, "at_most": self.at_most, "at_least": self.at_least, "is": self.is_}
        ((kind, stated),) = [(kind, stated) for kind, stated in wanted.items() if stated is not None]
        return kind, stated  # type: ignore[return-value]  # the keys above are kinds


class Reading(Table):
    """What differs from the scenarios as they are.

    set
        Values by `component.variable`.
    scenarios
        Scenarios by the name of those in whose place they run.
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
    statement: tuple[Statement, ...]
    reading: tuple[Reading, ...]


@dataclass(frozen=True)
class Case:
    """A scenario under a reading; `rotor` is the file of another rotor."""

    reading: Reading
    scenario: str
    flavour: Flavour = "native"
    rotor: str | None = None


@dataclass(frozen=True)
class Finding:
    """What a run shows of a statement, and how far that is from it."""

    found: Found
    misfit: float


def read_file() -> tuple[tuple[Statement, ...], tuple[Reading, ...]]:
    """Return all statements and readings."""
    source = files(__package__) / "readings.toml"
    content = validate(parse_toml(source.read_text(encoding="utf-8"), "readings"), _File, "readings")
    return content.statement, content.reading


def statements_of(chapter: int) -> list[Statement]:
    """Return the statements of a chapter."""
    return [statement for statement in read_file()[0] if statement.chapter == chapter]


def with_rotor(case: Case, folder: Path) -> Case:
    """Return the case with its reading's rotor, written to `folder`; a case whose reading has none as it is."""
    if not case.reading.rotor:
        return case
    path = rotor_file(load_scenario(case.scenario))
    data = read_toml(path, f"rotor file {path}")
    for table, values in case.reading.rotor.items():
        data[table] = {**data.get(table, {}), **values}
    written = folder / f"{case.reading.name.replace(' ', '_')}.toml"
    written.write_text(tomli_w.dumps(data), encoding="utf-8")
    return replace(case, rotor=str(written))


def prepare_case(case: Case) -> Prepared:
    """Return a case that is ready to run."""
    scenario = load_scenario(case.reading.scenarios.get(case.scenario, case.scenario))
    factor = case.reading.unbalance_factor
    changes = {"rotor": case.rotor, FACTOR: factor}
    scenario = scenario.model_copy(update={key: value for key, value in changes.items() if value is not None})
    return prepare(scenario, settings_for(scenario.system, case.reading.set), flavour=case.flavour)


def simulate_case(case: Case) -> list[Finding]:
    """Simulate a case and return what it shows of each statement of its scenario, in their order.

    Raises
    ------
    ValueError
        If it does not reach its end.
    """
    prepared = prepare_case(case)
    result = run_prepared(prepared)
    if result.outcome.failure is not None:
        raise ValueError(f"{case.scenario}, {case.reading.name}: {result.outcome.failure}")
    findings = []
    for statement in of_scenario(statements_of(case.reading.chapter), case.scenario):
        name, *arguments = statement.measure.split()
        if name in GIVEN:
            found: Found = GIVEN[name](prepared, *arguments)
        else:
            found = MEASURES[name](result.signals, *arguments)
        kind, wanted = statement.stated
        findings.append(Finding(found, misfit(found, wanted, kind)))
    return findings


def of_scenario(statements: Sequence[Statement], scenario: str) -> list[Statement]:
    """Return the statements of one scenario."""
    return [statement for statement in statements if statement.scenario == scenario]


def gain(prepared: Prepared, name: str) -> float:
    """Return k_b (N/m) or c_b (N s/m) of the first axis of the controller."""
    return float(prepared.plan.all_parameters(prepared.interfaces)[CONTROLLER][f"mb1.{name}_x"] or 0.0)


def critical_speed(prepared: Prepared, number: str) -> float:
    """Return a critical speed of forward whirl (Hz), counted from 1, on bearings with the controller's gains."""
    rotor = load_rotor(prepared.scenario.rotor or DEFAULT_ROTOR)
    rotor = rotor.on_equal_bearings(gain(prepared, "k_b"), gain(prepared, "c_b"))
    forward = [row.speed for row in campbell(rotor, up_to="300 rad/s").critical_speeds if row.whirl == "forward"]
    return forward[int(number) - 1] / (2.0 * math.pi)


GIVEN: dict[str, Callable[..., Found]] = {  # measures of what is run, not of the run
    FACTOR: lambda prepared: prepared.scenario.unbalance_factor,
    "gain": gain,
    "critical_speed": critical_speed,
}


def settings_for(system: str, given: Values) -> Values:
    """Return the settings for a system; on passive bearings, gains of the controller become those of the bearings."""
    if system != "passive":
        return given
    gains = {f"rolac_controller.*.{gain}_?": f"rotor_contact.mb?.{gain}" for gain in ("k_b", "c_b")}
    return {gains.get(name, name): value for name, value in given.items()}
