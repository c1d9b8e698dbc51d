"""The control loop of a run: its sensors, its excitation, and the table of receptances that belongs to it."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any

from amb_cosim.cosim.fmu.fmus import is_made_from_file, model_source
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.system import System
from amb_cosim.results.component_names import CONTROLLER, PLANT
from amb_cosim.scenario.rotors import named

# Names, and endings of names of signals and demands.
_PARAMETERS = ("delay", "chain.preset", "chain.filter", "chain.delay", "chain.cutoff")
_ENDINGS = (".gain", ".scale")


def check_control_loop(plan: Plan) -> None:
    """Check that sensors are connected, and that a table of receptances belongs to the loop; see `check_loop`.

    Raises
    ------
    ValueError
        If a sensor of a controller is not connected, so that it would always read zero; if the table belongs to another
        loop; or if no controller uses the table.
    """
    assembly = plan.assembly
    sensors = [f"{name}.{sensor}" for name, fmu in assembly.fmus.items() for sensor in _sensors(fmu.layout or {})]
    unfed = [sensor for sensor in sensors if assembly.system.source_of(sensor) is None]
    if unfed:
        problem = "is a sensor and must be connected; no component has an output with that name"
        raise ValueError("\n".join(f"{sensor} {problem}" for sensor in unfed))
    if (table := assembly.options.get("receptances")) is None:
        return
    from amb_cosim.model_constants.rotor_models import check_loop  # needed only by runs with a table

    controllers = [component.name for component in assembly.system.components if component.fmu == CONTROLLER]
    if not controllers:
        raise ValueError(f"receptances {named(table)} are not used: no component of the run is the model {CONTROLLER}")
    parameters = plan.all_parameters()
    inner = inner_loop_parameters(assembly.system, parameters)
    for controller in controllers:
        check_loop(table, parameters[controller], assembly.options.get("rotor"), inner)


def _sensors(layout: Mapping[str, Any]) -> list[str]:
    """Return the inputs that the layout of a model of this project lists as sensors."""
    return [*(plane[axis] for plane in layout.get("planes", ()) for axis in ("x", "y")), *layout.get("signals", ())]


def inner_loop_parameters(system: System, parameters: Mapping[str, Mapping[str, float | None]]) -> dict[str, float]:
    """Return the data that determine the responses of linear controllers: parameters, and a CRC-32 of their matrices.

    Parameters
    ----------
    system
        The system of the run.
    parameters
        The parameters of the system, by component and name.
    """
    data: dict[str, float] = {}
    for component in system.components:
        if not is_made_from_file(component.fmu):
            continue
        values = parameters[component.name]
        names = [name for name in values if name in _PARAMETERS or name.endswith(_ENDINGS)]
        data |= {f"{component.name}.{name}": float(values[name] or 0.0) for name in names}
        data[f"{component.name}.matrices"] = float(zlib.crc32(model_source(component.fmu)[1].tobytes()))
    return data


def exciting_components(system: System) -> list[str]:
    """Return the components that supply signals and receive none of the rotor's lateral motion.

    A generator of test forces is such a component, even if it reads the speed. A drive and a sensor of speed or angle
    are not, because they pass on only the rotation.
    """
    ends = [(system.split(link.source), system.split(link.target)) for link in system.connections]
    links = {(sender, receiver) for (sender, a), (receiver, b) in ends if not is_rotation(a) and not is_rotation(b)}
    moved = {PLANT}
    while more := {receiver for sender, receiver in links if sender in moved} - moved:
        moved |= more
    return sorted({sender for sender, _ in links} - moved)


def excitations(system: System) -> list[str]:
    """Return the names of the signals by which `exciting_components` act on other components."""
    sources = exciting_components(system)
    fed = {link.source for link in system.connections if system.split(link.source)[0] in sources}
    return sorted(name for name in fed if not is_rotation(system.split(name)[1]))


def is_rotation(variable: str) -> bool:
    """Return whether a variable of the plant or of a controller describes the rotation of the rotor."""
    return variable in ("Omega", "Omega_dot", "speed", "theta") or variable.startswith("drive.")
