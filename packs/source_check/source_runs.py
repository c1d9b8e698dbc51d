"""Prepares the run of a scenario from which statements are evaluated."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, load_scenario
from rotor_analysis.rotor_file import load_rotor
from source_check.statements import Source


def prepare_source(source: Source) -> ScenarioPlan:
    """Return the prepared run of a source.

    Raises
    ------
    ValueError
        If the scenario, a value, or a table of the rotor is not allowed.
    """
    return prepare_run(scenario_of(source), dict(source.set))


def scenario_of(source: Source) -> Scenario:
    """Return the scenario of a source, without the values that the source sets."""
    scenario = load_scenario(source.scenario)
    if source.rotor_file:
        scenario = scenario.changed(rotor=source.rotor_file)
    if source.system:
        scenario = _on_system(scenario, source.system)
    changes: dict[str, Any] = {"end_cycle": source.end_cycle, "unbalance_factor": source.unbalance_factor}
    if source.rotor:
        changes["rotor"] = load_rotor(scenario.rotor, source.rotor)
    settings = {key: value for key, value in changes.items() if value is not None}
    if "end_cycle" in settings:
        settings["end_time"] = None
    return scenario.changed(**settings)


def _on_system(scenario: Scenario, system: str) -> Scenario:
    """Return a scenario for another system, without settings for components that this system lacks."""
    names = {component.name for component in load_system(system).components}
    events = tuple(
        event.model_copy(update={"set": {name: values for name, values in event.set.items() if name in names}})
        for event in scenario.event
    )
    inputs, parameters = (
        {name: values for name, values in table.items() if name in names}
        for table in (scenario.inputs, scenario.parameters)
    )
    return scenario.model_copy(update={"system": system, "event": events, "inputs": inputs, "parameters": parameters})


def build_fmus(sources: Iterable[Source]) -> None:
    """Build the FMUs of each rotor before several processes need them; errors are reported when a source is run."""
    seen: set[str] = set()
    for source in sources:
        if not source.scenario:
            continue
        try:
            scenario = load_scenario(source.scenario)
            system = source.system or scenario.system
            rotor = json.dumps([source.rotor_file or scenario.rotor, system, source.rotor], sort_keys=True)
            if rotor not in seen:
                seen.add(rotor)
                prepare_source(source)
        except ValueError:
            continue
