"""The interface of a model's FMU, made from the variable table as if it were read from an FMI 2.0 description."""

from __future__ import annotations

import math

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, UnitDefinition
from fmi_export.building.units import SI, base_unit
from fmi_export.model import Model
from fmi_export.variables import LARGEST, Variable

OF_UNIT = {**dict.fromkeys(SI, 0.0), "factor": 1.0, "offset": 0.0}


def interface_of(model: Model) -> FmuInterface:
    """Return the interface of a model's FMU, except its GUID, before the FMU is built."""
    variables = model.interface.variables
    inputs = {v.name for v in variables if v.causality == "input"}
    definitions = {unit: _definition(unit) for unit in {v.unit for v in variables if v.type == "Real"}}
    ports = {v.name: _port(v, k, definitions, inputs) for k, v in enumerate(variables)}
    return FmuInterface(
        model.name, "", "", ports, model.variable_step, saves_state=True, serialises_state=True, reports_faults=True
    )


def _definition(unit: str) -> UnitDefinition:
    return tuple(float(value) for value in {**OF_UNIT, **base_unit(unit)}.values())


def _port(v: Variable, reference: int, definitions: dict[str, UnitDefinition], inputs: set[str]) -> Port:
    unit = v.unit if v.type == "Real" else None
    return Port(
        name=v.name,
        type=v.type,
        causality=v.causality,
        reference=reference,
        unit=unit,
        definition=definitions.get(v.unit) if unit is not None else None,
        minimum=-math.inf if v.type == "Boolean" or v.minimum <= -LARGEST else float(v.minimum),
        maximum=math.inf if v.type == "Boolean" or v.maximum >= LARGEST else float(v.maximum),
        start=None if v.causality == "output" else float(v.start if v.type == "Real" else int(v.start)),
        description=v.description,
        depends_on=tuple(name for name in v.depends_on if name in inputs),
        warning=v.warning,
        over_step=v.over_step,
        items={name: k for k, name in enumerate(v.enumeration.names)} if v.enumeration else {},
        variability=v.variability,
        stored="Enumeration" if v.enumeration else v.type,
    )
