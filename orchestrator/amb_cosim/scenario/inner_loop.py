"""Dependence of a table of receptances on the loop in which it was identified."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from pathlib import Path

from amb_cosim.cosim.fmu.fmus import MADE_FROM_FILE, model_source
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.system import System
from amb_cosim.results.component_names import CONTROLLER

# Names, and endings of names of signals and demands.
_PARAMETERS = ("delay", "chain.preset", "chain.filter", "chain.delay", "chain.cutoff")
_ENDINGS = (".gain", ".scale")


def check_receptances(assembly: Assembly, plan: Plan) -> None:
    """Raise ValueError if the table of receptances of a run is that of another loop; see `check_loop`."""
    if (table := assembly.options.get("receptances")) is None:
        return
    from amb_cosim.design.rotor_models import check_loop  # a run without a table needs nothing of it

    parameters = plan.all_parameters(assembly.interfaces)
    inner = inner_loop_parameters(assembly.system, parameters)
    for component in controllers(assembly.system):
        check_loop(table, parameters[component], assembly.options.get("rotor"), inner)


def controllers(system: System) -> list[str]:
    """Return the components that are the controller model, which uses receptances."""
    return [component.name for component in system.components if component.fmu == CONTROLLER]


def inner_loop_parameters(system: System, parameters: Mapping[str, Mapping[str, float | None]]) -> dict[str, float]:
    """Return the data that determine the responses of linear controllers: parameters, and a CRC-32 of their matrices.

    Parameters
    ----------
    system
        Of the run.
    parameters
        By component and name.
    """
    result: dict[str, float] = {}
    for component in system.components:
        if Path(component.fmu).suffix not in MADE_FROM_FILE:
            continue
        values = parameters[component.name]
        names = [name for name in values if name in _PARAMETERS or name.endswith(_ENDINGS)]
        result |= {f"{component.name}.{name}": float(values[name] or 0.0) for name in names}
        result[f"{component.name}.matrices"] = float(zlib.crc32(model_source(component.fmu)[1].tobytes()))
    return result
