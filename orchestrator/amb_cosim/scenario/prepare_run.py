"""Prepares the run of a scenario: finds its FMUs, checks their system, and plans the run on the time grid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.cosim.system.assembly import Assembly, assemble
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.file import check_exists
from amb_cosim.scenario.plan import ScenarioPlan, scenario_plan
from amb_cosim.scenario.rotors import table_source
from amb_cosim.scenario.scenario import Scenario
from amb_cosim.scenario.stators import lacking_stators, stators_of_run
from amb_files.checks import errors_in
from amb_files.plain_values import plain_values


def prepare_run(
    scenario: Scenario,
    settings: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    options: RunOptions = DEFAULTS,
) -> ScenarioPlan:
    """Find the FMUs of a scenario, check its system and plan its run; see `scenario_plan` for the arguments.

    A run that continues from `options.start` has the same stators as its past; a warning is added if magnets without
    such stators lose their power.

    Raises
    ------
    ValueError
        If a name, a value, a time or a connection is not allowed.
    """
    settings = plain_values(settings, "set")
    assembly = assemble_scenario(scenario, settings, options)
    plan = scenario_plan(scenario, assembly, settings, until)
    if options.start is not None:
        lacking = lacking_stators(scenario, assembly, settings, options.start)
        plan = replace(plan, warnings=(*plan.warnings, *lacking))
    return plan


def assemble_scenario(
    scenario: Scenario, settings: Mapping[str, Raw] | None = None, options: RunOptions = DEFAULTS
) -> Assembly:
    """Find the FMUs of a scenario and check its system; the result holds for any values of the scenario.

    The `settings` only determine which stators the rotor can touch (see `stators_of_run`).

    Raises
    ------
    ValueError
        If an FMU is not available, or the system does not match the interfaces.
    """
    made_with, system = model_options(scenario), system_of(scenario)
    stators = stators_of_run(scenario, system, settings or {}, options.start)
    return assemble(system, options.flavour, stators=stators, **made_with)


def model_options(scenario: Scenario) -> dict[str, Any]:
    """Return the options (rotor and receptances) with which a scenario's models are made, except touchable stators.

    Raises
    ------
    ValueError
        If a file does not exist.
    """
    with errors_in(f"scenario {scenario.name}"):
        check_exists("rotor", scenario.rotor)
        check_exists("receptances", scenario.receptances)
    return {"rotor": scenario.rotor, "receptances": table_source(scenario.receptances)}


def system_of(scenario: Scenario) -> System:
    """Return the system of a scenario, in which the scenario's FMUs replace components.

    Raises
    ------
    ValueError
        If a file does not exist, or does not describe a system.
    """
    with errors_in(f"scenario {scenario.name}"):
        check_exists("system", scenario.system)
    system = load_system(scenario.system, {"gradient": scenario.gradient})
    with errors_in(f"scenario {scenario.name}"):
        for component, fmu in scenario.fmu.items():
            system = system.with_fmu(component, fmu)
            check_exists(f"fmu.{component}", fmu)
    return system
