"""The levitated rotor as one FMU: controller, actuator and plant of a system, with a scenario's start values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from amb_cosim.cosim.choices import Flavour, Fmi
from amb_cosim.cosim.fmu_interface import FmuInterface, read_interface
from amb_cosim.cosim.fmus import build_models, model_source
from amb_cosim.cosim.patterns import expand
from amb_cosim.cosim.simulation import Assembly
from amb_cosim.cosim.system import System
from amb_cosim.cosim.system_file import load_system
from amb_cosim.packaging.models import Made
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.plan import plan_scenario
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_files.stages import stage

if TYPE_CHECKING:
    from fmi_export.model import Model

NAME = "levitated_rotor"
SYSTEM = "levitated"  # what is assembled without a scenario
IN_ORDER = (CONTROLLER, ACTUATOR, PLANT)  # models of the components, as they step


def build_assembled(
    folder: str | Path,
    scenario: str | Path | Scenario | None = None,
    flavour: Flavour = "native",
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    platforms: Iterable[str] | None = None,
    fmi: Fmi = 2,
) -> Path:
    """Write the FMU `levitated_rotor`, which holds rotor, actuator and controller, into a folder and return its path.

    Parameters
    ----------
    scenario
        Whose system is assembled, of whose rotor, and whose parameters and first inputs are the start values: a
        `Scenario`, a name or the path of a TOML file; the system `levitated` by default.
    rotor, receptances
        In place of the scenario's; see `build`.
    folder, flavour, platforms, fmi
        As for `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is wrong, its system is not of these three components, or the FMU cannot be built.
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
    if scenario is not None and not isinstance(scenario, Scenario):
        scenario = load_scenario(str(scenario))
    system = _system(scenario)
    rotor = rotor or (scenario.rotor if scenario else None)
    receptances = receptances or (scenario.receptances if scenario else None)
    table = None if receptances is None else Path(receptances)
    made = {c.name: model_source(c.fmu, rotor=rotor, receptances=table) for c in system.components}
    interfaces = {name: _interface(model) for name, (model, _) in made.items()}
    system = expand(system, interfaces)
    system.check(interfaces)
    parameters, inputs = _values(Assembly(system, {}, interfaces), scenario, rotor)
    controller = system.components[0].name
    if table is not None:
        from amb_cosim.design.rotor_models import check_loop

        check_loop(table, parameters[controller], rotor)
    return _made(system, made, parameters, inputs)


def _system(scenario: Scenario | None) -> System:
    """Return the system of a scenario; raises ValueError unless it can be assembled."""
    if scenario is None:
        return load_system(SYSTEM)
    system = load_system(scenario.system, {"gradient": scenario.gradient})
    for component, fmu in scenario.fmu.items():
        system = system.with_fmu(component, fmu)
    found = tuple(component.fmu for component in system.components)
    if found != IN_ORDER:
        raise ValueError(
            f"{NAME} is assembled of {', '.join(IN_ORDER)}, in this order; system {system.name} of scenario "
            f"{scenario.name} has {', '.join(found)}"
        )
    coupling = scenario.coupling or system.coupling
    if coupling != "gauss_seidel":
        raise ValueError(
            f"{NAME} couples its parts in Gauss-Seidel order; scenario {scenario.name} asks for {coupling}"
        )
    return system


def _interface(model: Model) -> FmuInterface:
    """Return the interface that the FMU of a model would have."""
    from fmi_export.building.description import model_description

    with stage() as folder:
        description = ElementTree.tostring(model_description(model, "", "", ""))
        (folder / "modelDescription.xml").write_bytes(description)
        return read_interface(folder, model.name)


def _values(
    assembly: Assembly, scenario: Scenario | None, rotor: str | Path | None
) -> tuple[Mapping[str, Mapping[str, float]], Mapping[str, float]]:
    """Return parameters by component and inputs by name that a scenario, or the system alone, gives values."""
    if scenario is None:
        values = assembly.assignments()
        return values.parameters, values.inputs
    plan = plan_scenario(scenario.model_copy(update={"rotor": None if rotor is None else str(rotor)}), assembly)
    return plan.parameters, plan.inputs


def _made(
    system: System,
    made: Mapping[str, Made],
    parameters: Mapping[str, Mapping[str, float]],
    inputs: Mapping[str, float],
) -> Made:
    from fmi_export.model import with_starts
    from levitated_rotor.assembly import Assembly as Parts
    from levitated_rotor.assembly import Part
    from levitated_rotor.constants import constants_of
    from levitated_rotor.model import model_for

    controller, actuator, plant = (Part(name, model) for name, (model, _) in made.items())
    start = {f"{component}.{name}": value for component, of in parameters.items() for name, value in of.items()}
    parts = Parts(
        (controller, actuator, plant),
        {link.target: link.source for link in system.connections},
        {signal.name: signal.targets for signal in system.signals},
    )
    model = with_starts(model_for(parts), start | dict(inputs))
    step_size = model.interface[f"{controller.name}.sample_time"].start
    return replace(model, step_size=step_size), constants_of(parts, [constants for _, constants in made.values()])
