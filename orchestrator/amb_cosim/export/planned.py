"""Plans for running models, made before FMUs are built, with start values from a scenario or a system file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amb_cosim.cosim.fmu.fmus import is_model, model_source, models
from amb_cosim.cosim.fmu.model_interface import interface_of
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Experiment, Plan
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.replacement import fitted
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import is_system, load_experiment, load_system
from amb_cosim.export.models import Made
from amb_cosim.scenario.control_loop import check_control_loop
from amb_cosim.scenario.plan import scenario_plan
from amb_cosim.scenario.prepare_run import model_options, system_of
from amb_cosim.scenario.rotors import RotorSource, TableSource, table_source
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_cosim.scenario.stators import stators_of_run

STEP_SIZE = 250e-6  # s, default communication step


@dataclass(frozen=True)
class PlannedModels:
    """A plan, with the model and constants of each component."""

    plan: Plan
    made: Mapping[str, Made]


def plan_models(
    scenario: str | Path | Scenario,
    rotor: RotorSource = None,
    receptances: TableSource = None,
) -> PlannedModels:
    """Plan a run of models without building FMUs.

    Parameters
    ----------
    scenario
        A `Scenario`, or the name or TOML file of a scenario; or a system, given by its name or file.
    rotor, receptances
        Values that replace those of the scenario; see `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is invalid, or a component of the system is not a model.
    """
    experiment = None
    if isinstance(scenario, str | Path) and is_system(scenario):
        system, experiment = load_system(scenario), load_experiment(scenario, Experiment(STEP_SIZE, STEP_SIZE))
        options: dict[str, Any] = {"rotor": rotor, "receptances": table_source(receptances)}
    else:
        resolved = as_scenario(scenario, rotor, receptances)
        system = system_of(resolved)
        options = {**model_options(resolved), "stators": stators_of_run(resolved, system, {})}
    made = made_for(system, **options)
    system, interfaces = fitted(
        system,
        {name: interface_of(model) for name, (model, _) in made.items()},
        lambda component: interface_of(model_source(component.fmu, **options)[0]),
    )
    assembly = Assembly(system, {}, interfaces, options)
    if experiment is None:
        return PlannedModels(scenario_plan(resolved, assembly), made)
    plan = experiment_plan(experiment, assembly)
    check_control_loop(plan)
    return PlannedModels(plan, made)


def made_for(system: System, source: Callable[..., Made] = model_source, **options: Any) -> dict[str, Made]:
    """Return the model and constants of each component of a system, from `model_source` or another `source`.

    Raises
    ------
    ValueError
        If a component is not a model, or cannot be made with these options.
    """
    for component in (c for c in system.components if not is_model(c.fmu)):
        is_built = Path(str(component.fmu)).is_file()
        built = "is already an FMU: it can neither receive start values nor become part of another FMU"
        raise ValueError(
            f"{component.name} of system {system.name}: {component.fmu} {built if is_built else 'is not a file'}; it "
            f"must be one of the models {', '.join(models())}"
        )
    return {c.name: source(c.fmu, **options) for c in system.components}
