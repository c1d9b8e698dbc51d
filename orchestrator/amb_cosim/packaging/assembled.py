"""Systems as one FMU: the levitated rotor, or any other whose components are models, with a scenario's start values."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from amb_cosim.cosim.assembly import Assembly
from amb_cosim.cosim.choices import Coupling, Flavour, Fmi
from amb_cosim.cosim.experiment import Experiment, Plan, plan_experiment
from amb_cosim.cosim.fmu_interface import FmuInterface, read_interface
from amb_cosim.cosim.fmus import build_models, is_model, model_source, models
from amb_cosim.cosim.replacement import fitted
from amb_cosim.cosim.system import System
from amb_cosim.cosim.system_file import is_system, load_experiment, load_system
from amb_cosim.packaging.models import Made
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.inner_loop import inner_loop_parameters
from amb_cosim.scenario.plan import plan_scenario
from amb_cosim.scenario.scenario import Scenario, given_scenario
from amb_cosim.scenario.simulation import system_of
from amb_files.stages import stage

if TYPE_CHECKING:
    from fmi_export.model import Model

NAME = "levitated_rotor"
DESCRIPTION = (
    "Flexible rotor levitated by magnetic bearings under sampled control, in one: rotor_contact, amb_actuator and "
    "rolac_controller"
)
SYSTEM = "levitated"  # what is assembled without a scenario
IN_ORDER = (CONTROLLER, ACTUATOR, PLANT)  # models of the components of what is called so, as they step
STEP_SIZE = 250e-6  # s, communication step where nothing says it


def build_assembled(
    folder: str | Path,
    scenario: str | Path | Scenario | None = None,
    flavour: Flavour = "native",
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    platforms: Iterable[str] | None = None,
    fmi: Fmi = 2,
) -> Path:
    """Write one FMU with all components of a system into a folder and return its path.

    It is `levitated_rotor` where these are controller, actuator and rotor, and called like the system otherwise.

    Parameters
    ----------
    scenario
        Whose system is assembled, of whose rotor, and whose parameters and first inputs are the start values: a
        `Scenario`, a name or the path of a TOML file; the path of a system file; the system `levitated` by default.
    rotor, receptances
        In place of the scenario's; see `build`.
    folder, flavour, platforms, fmi
        As for `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is wrong, a component of the system is no model, its coupling is iterative, or the FMU
        cannot be built.
    """
    options = {"scenario": scenario, "rotor": rotor, "receptances": receptances}
    (path,) = build_models((NAME,), Path(folder), flavour, platforms, fmi, **options)
    return path


def levitated_rotor(
    scenario: str | Path | Scenario | None = None,
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    **_: Any,
) -> Made:
    """Return the assembled model and its constants; see `build_assembled` for the arguments and errors."""
    from fmi_export.model import with_starts

    file = scenario if isinstance(scenario, str | Path) and is_system(scenario) else None
    if scenario is None or file is not None:
        scenario, system = None, load_system(file or SYSTEM)
    else:
        scenario = given_scenario(scenario)
        system = system_of(scenario)
        rotor, receptances = rotor or scenario.rotor, receptances or scenario.receptances
    table = None if receptances is None else Path(receptances)
    made = made_for(system, rotor=rotor, receptances=table)
    options = {"rotor": rotor, "receptances": table}
    system, interfaces = fitted(
        system,
        {name: _interface(model) for name, (model, _) in made.items()},
        lambda component: _interface(model_source(component.fmu, **options)[0]),
    )
    assembly = Assembly(system, {}, interfaces)
    if scenario is None:
        plan = _plan(assembly, file)
    else:
        plan = plan_scenario(scenario.model_copy(update={"rotor": None if rotor is None else str(rotor)}), assembly)
    if table is not None:
        from amb_cosim.design.rotor_models import check_loop

        given = plan.all_parameters(interfaces)
        inner = inner_loop_parameters(system, given)
        for component in system.components:
            if component.fmu == CONTROLLER:
                check_loop(table, given[component.name], rotor, inner)
    model, constants = assembled(plan, made, scenario.coupling if scenario else None)
    starts = {f"{component}.{name}": value for component, of in plan.parameters.items() for name, value in of.items()}
    return with_starts(model, starts | dict(plan.inputs)), constants


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
            f"{', '.join(files)} of system {system.name} cannot be assembled: only models can, {', '.join(models())}"
        )
    return {c.name: source(c.fmu, **options) for c in system.components}


def assembled(plan: Plan, made: Mapping[str, Made], coupling: Coupling | None = None) -> Made:
    """Return the model of a planned system whose components are these models, and its constants.

    Steps are cut at the samples of the one component that has a sample time, else at the communication step.

    Parameters
    ----------
    coupling
        In place of the system's.

    Raises
    ------
    ValueError
        If the coupling is iterative.
    """
    from fmi_export.model import Part
    from levitated_rotor.assembly import Composite
    from levitated_rotor.model import model_for

    system = plan.system
    coupling = coupling or system.coupling
    if coupling == "iterative":
        raise ValueError("coupling = 'iterative' is not allowed in an assembly; it must be 'gauss_seidel' or 'jacobi'")
    composite = Composite(
        tuple(Part(c.name, *made[c.name], c.every) for c in system.components),
        {link.target: link.source for link in system.connections},
        {signal.name: signal.targets for signal in system.signals},
        plan.step_size,
        coupling == "jacobi",
    )
    constants = np.concatenate([part.constants for part in composite.parts])
    if tuple(c.fmu for c in system.components) == IN_ORDER and coupling == "gauss_seidel":
        return model_for(composite, NAME, DESCRIPTION), constants
    name = re.sub(r"\W", "_", system.name, flags=re.ASCII)
    description = system.description or f"System {system.name}"
    return model_for(composite, f"_{name}" if name[0].isdigit() else name, description), constants


def _interface(model: Model) -> FmuInterface:
    """Return the interface that the FMU of a model would have."""
    from fmi_export.building.description import model_description

    with stage() as folder:
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
