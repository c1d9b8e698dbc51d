"""A scenario for the live rig: its plan as JSON, and the bytes of a single FMU that contains all components."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmus import fmu_name, model_source
from amb_cosim.export.assembled import assembled
from amb_cosim.export.models import Made
from amb_cosim.export.planned import made_for
from amb_cosim.presentation.units import speed_unit, with_speeds_in
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.results.places import places_of
from amb_cosim.scenario.plan import ScenarioPlan, scenario_plan
from amb_cosim.scenario.prepare_run import assemble_scenario
from amb_cosim.scenario.rotors import named
from amb_cosim.scenario.scenario import Scenario
from amb_live.geometry import geometry
from fmi_export.variables import FAULT_CODE

if TYPE_CHECKING:
    from fmi_export.model import Model

WEBASSEMBLY = "wasm32"  # platform of the modules
POWER_LOSS = {f"{ACTUATOR}.*.amplifier_off_?": True}  # at any time, by the user of the page


@dataclass(frozen=True)
class Rig:
    """A scenario for the page.

    data
        A `Rig` as defined by `protocol.js`, for a JSON file.
    parts
        Module and constants of the FMU, by the keys in `data`.
    """

    data: dict[str, Any]
    parts: Mapping[str, bytes]


def rig(scenario: Scenario, source: Callable[..., Made] = model_source) -> Rig:
    """Return a scenario with everything that a browser needs to run it.

    Parameters
    ----------
    source
        Function that returns models as `model_source` does; several rigs may share them.

    Raises
    ------
    ValueError
        If the scenario is invalid, or requires features that a browser lacks, such as an FMU file or iterative
        coupling.
    """
    assembly = assemble_scenario(scenario, POWER_LOSS)
    plan = scenario_plan(scenario, assembly)
    _check(plan)
    model, parts = _fmu(plan, source)
    system = plan.system
    module, guid = parts
    names = [v.name for v in model.interface.variables if v.name != FAULT_CODE]  # the last one
    components = [
        {
            "name": c.name,
            "model": fmu_name(c.fmu),
            "guid": plan.interfaces[c.name].guid,
            "variables": [_variable(port) for port in plan.interfaces[c.name].ports.values()],
            "parameters": dict(plan.parameters[c.name]),
        }
        for c in system.components
    ]
    data = {
        "format": 1,
        "version": importlib.metadata.version("amb-cosim"),
        "scenario": scenario.name,
        "description": with_speeds_in(scenario.description, speed_unit()),
        "source": scenario.source,
        "system": scenario.system,
        "rotor": named(scenario.rotor),
        "receptances": named(scenario.receptances),
        "gradient": scenario.gradient,
        "stepSize": plan.step_size,
        "rate": round(1.0 / plan.step_size),
        "first": plan.first,
        "last": plan.last,
        "period": plan.period,
        "module": module,
        "guid": guid,
        "data": guid,
        "variables": names,
        "components": components,
        "signals": [{"name": signal.name, "targets": list(signal.targets)} for signal in system.signals],
        "inputs": dict(plan.inputs),
        "events": _events(plan),
        "ramps": [{"variable": r.variable, "points": list(map(list, r.points)), "slope": r.slope} for r in plan.ramps],
        "stops": [condition._asdict() for condition in plan.stops],
        "recorded": [name for name in plan.recorded if name in names],
        "geometry": geometry(
            scenario.rotor,
            plan.fmus[PLANT].layout or {},
            _gravity_angle(plan),
            places_of(plan.assembly).magnetic,
        ),
    }
    return Rig(data, parts)


def _check(plan: ScenarioPlan) -> None:
    if plan.assembly.from_elsewhere:
        name = plan.assembly.from_elsewhere[0]
        path = plan.fmus[name].path
        raise ValueError(f"{name} is the FMU file {path}; the live rig runs only this project's models")
    if PLANT not in plan.interfaces:
        raise ValueError(f"system {plan.assembly.system.name} has no component {PLANT}, which the live rig requires")


def _variable(port: Port) -> dict[str, Any]:
    variable: dict[str, Any] = {
        "name": port.name,
        "reference": port.reference,
        "type": port.type,
        "causality": port.causality,
        "variability": port.variability,
        "unit": "" if port.unit in (None, "1") else port.unit,
        "min": port.minimum if math.isfinite(port.minimum) else None,
        "max": port.maximum if math.isfinite(port.maximum) else None,
        "start": port.start if port.causality != "output" else None,
        "description": port.description,
    }
    return variable | ({"items": dict(port.items)} if port.items else {})


def _events(plan: ScenarioPlan) -> list[dict[str, Any]]:
    named = [event for event in plan.scenario.event if event.name]
    labels = {plan.marks[event.name]: event.name for event in named}
    roles = {event.name: event.role for event in named if event.role}
    return [
        {
            "point": point,
            "variable": variable,
            "value": value,
            "label": (label := labels.get(point, "")),
            "role": roles.get(label, ""),
        }
        for point, variable, value in plan.events
    ]


def _gravity_angle(plan: ScenarioPlan) -> float:
    """Return the direction of gravity (rad), from x towards y."""
    interface: FmuInterface = plan.interfaces[PLANT]
    start = interface.ports["gravity_angle"].start or 0.0
    return plan.parameters[PLANT].get("gravity_angle", start)


def _fmu(plan: ScenarioPlan, source: Callable[..., Made]) -> tuple[Model, dict[str, bytes]]:
    """Return a single model of all components, and the bytes of its FMU: the module, and the constants by GUID.

    Start values come from the models, so scenarios with the same system and rotor share the FMU.
    """
    from fmi_export.building.native.data import model_data
    from fmi_export.building.native.engines import engine, engine_key
    from fmi_export.building.native.package import native_guid

    models = made_for(plan.system, source, **plan.assembly.options)
    model, constants = assembled(plan, models)
    key, guid = engine_key(model.compiled), native_guid(model, constants)
    module = engine(model.compiled, WEBASSEMBLY).library
    return model, {key: module, guid: model_data(model, constants, guid, key)}
