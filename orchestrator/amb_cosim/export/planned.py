"""A planned run of models, before any of them is an FMU: what a scenario or a system file gives them to start with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from amb_cosim.cosim.basics.choices import Coupling
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmus import is_model, model_source, models
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Experiment, Plan
from amb_cosim.cosim.system.planning import plan_experiment
from amb_cosim.cosim.system.replacement import fitted
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import is_system, load_experiment, load_system
from amb_cosim.export.models import Made
from amb_cosim.results.places import CONTROLLER
from amb_cosim.scenario.inner_loop import inner_loop_parameters
from amb_cosim.scenario.plan import plan_scenario
from amb_cosim.scenario.scenario import Scenario, given_scenario
from amb_cosim.scenario.simulation import system_of
from amb_files.temporary_folders import temporary_folder

if TYPE_CHECKING:
    from fmi_export.model import Model

STEP_SIZE = 250e-6  # s, communication step where nothing says it


@dataclass(frozen=True)
class PlannedModels:
    """A plan, model and constants of each component, and the scenario's coupling, if it has one of its own."""

    plan: Plan
    made: Mapping[str, Made]
    coupling: Coupling | None = None


def plan_models(
    scenario: str | Path | Scenario,
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
) -> PlannedModels:
    """Plan a run of models; no FMU of theirs is built.

    Parameters
    ----------
    scenario
        A `Scenario`, a name or the path of a TOML file; or a system, by its name or the path of its file.
    rotor, receptances
        In place of the scenario's; see `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is wrong, or a component of the system is no model.
    """
    file = scenario if isinstance(scenario, str | Path) and is_system(scenario) else None
    if file is not None:
        values, system = None, load_system(file)
    else:
        values = given_scenario(scenario)
        system = system_of(values)
        rotor, receptances = rotor or values.rotor, receptances or values.receptances
    table = None if receptances is None else Path(receptances)
    options: dict[str, Any] = {"rotor": rotor, "receptances": table}
    made = made_for(system, **options)
    system, interfaces = fitted(
        system,
        {name: _interface(model) for name, (model, _) in made.items()},
        lambda component: _interface(model_source(component.fmu, **options)[0]),
    )
    assembly = Assembly(system, {}, interfaces)
    if values is None:
        plan = _plan(assembly, file)
    else:
        plan = plan_scenario(values.model_copy(update={"rotor": None if rotor is None else str(rotor)}), assembly)
    if table is not None:
        from amb_cosim.design.rotor_models import check_loop

        parameters = plan.all_parameters(interfaces)
        inner = inner_loop_parameters(system, parameters)
        for component in system.components:
            if component.fmu == CONTROLLER:
                check_loop(table, parameters[component.name], rotor, inner)
    return PlannedModels(plan, made, values.coupling if values else None)


def made_for(system: System, source: Callable[..., Made] = model_source, **options: Any) -> dict[str, Made]:
    """Return model and constants of each component of a system, from `model_source` or what keeps its answers.

    Raises
    ------
    ValueError
        If a component is no model, or cannot be made with these options.
    """
    files = [component.name for component in system.components if not is_model(component.fmu)]
    if files:
        raise ValueError(
            f"{', '.join(files)} of system {system.name} cannot be built: only models can, {', '.join(models())}"
        )
    return {c.name: source(c.fmu, **options) for c in system.components}


def _interface(model: Model) -> FmuInterface:
    """Return the interface that the FMU of a model would have."""
    from fmi_export.building.description import model_description

    with temporary_folder() as folder:
        description = ElementTree.tostring(model_description(model, "", "", ""))
        (folder / "modelDescription.xml").write_bytes(description)
        return read_interface(folder, model.name)


def _plan(assembly: Assembly, file: str | Path | None) -> Plan:
    """Return what the experiment of a system file says, if it has one."""
    experiment, values = Experiment(STEP_SIZE, STEP_SIZE), assembly.assignments()
    if file is not None:
        experiment, inputs = load_experiment(file, experiment)
        for name, raw in inputs.items():
            values.set_first(name, raw)
    return plan_experiment(experiment, values)
