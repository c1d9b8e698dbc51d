"""The run of a scenario that statements are computed from."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import tomli_w

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_cosim.scenario.simulation import PlannedRun, prepare
from amb_files.atomic import write_atomically
from amb_files.toml import read_toml
from rotor_analysis.packaged_rotors import rotor_path
from source_check.statements import Source


def prepare_source(source: Source, rotor_file: Path, flavour: Flavour = "native") -> PlannedRun:
    """Return the scenario of a source, ready to run; a rotor of its own is written to `rotor_file`.

    Raises
    ------
    ValueError
        If the scenario, a value or a table of the rotor is wrong.
    """
    return prepare(scenario_of(source, rotor_file), dict(source.set), flavour=flavour)


def scenario_of(source: Source, rotor_file: Path) -> Scenario:
    """Return the scenario of a source without the values that it sets; arguments and errors as for `prepare_source`."""
    scenario = load_scenario(source.scenario)
    if source.rotor_file:
        scenario = scenario.changed(rotor=source.rotor_file)
    changes: dict[str, Any] = {"end_cycle": source.end_cycle, "unbalance_factor": source.unbalance_factor}
    if source.rotor:
        content = read_toml(rotor_path(scenario.rotor), "rotor file")
        content |= {table: {**content.get(table, {}), **values} for table, values in source.rotor.items()}
        write_atomically(rotor_file, lambda file: file.write_text(tomli_w.dumps(content), encoding="utf-8"))
        changes["rotor"] = str(rotor_file)
    settings = {key: value for key, value in changes.items() if value is not None}
    if "end_cycle" in settings:
        settings["end_time"] = None
    return scenario.changed(**settings)


def build_fmus(sources: Iterable[Source], folder: Path, flavour: Flavour = "native") -> None:
    """Build the FMUs of each rotor before several processes need them; what is wrong with a source its run tells."""
    seen: set[str] = set()
    for source in sources:
        if not source.scenario:
            continue
        try:
            scenario = load_scenario(source.scenario)
            rotor = json.dumps([source.rotor_file or scenario.rotor, scenario.system, source.rotor], sort_keys=True)
            if rotor not in seen:
                seen.add(rotor)
                prepare_source(source, folder / "rotor.toml", flavour)
        except ValueError:
            continue
