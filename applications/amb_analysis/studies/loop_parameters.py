"""Changeable parameters of the components of a machine, such as the constants of its magnets.

Only the named values change. Values that a plan derives from the named values, such as the constants that a controller
assumes for its magnets, stay as they are. This corresponds to the measured machine, whose controller gains did not
depend on the actual magnets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from amb_analysis.machine.machine import Machine
from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.values import Raw, convert
from amb_cosim.scenario.prepare_run import system_of
from amb_cosim.scenario.scenario import Scenario
from amb_files.suggestions import suggest
from amb_files.wildcards import is_pattern
from array_types import Array
from rotor_analysis.rotor import Rotor

Values = Mapping[str, Mapping[str, float]]
"""Values of parameters by component and name."""


@dataclass(frozen=True)
class LoopParameters:
    """A machine, and the names of those parameters of its components that may change.

    names
        Names as `component.variable`; if a name contains `*` or `?`, one number applies to all matching variables.
    ports
        Variables that match each name.
    start
        Values of the parameters in the scenario.
    """

    machine: Machine
    names: tuple[str, ...]
    ports: tuple[tuple[Port, ...], ...]
    start: tuple[float, ...]

    @classmethod
    def of(cls, machine: Machine, names: Sequence[str]) -> LoopParameters:
        """Find parameters by their names.

        Raises
        ------
        ValueError
            If a name does not denote a number, or matches numbers with different values.
        """
        ports = tuple(_numbers(machine, name) for name in names)
        start = tuple(_start(machine, name, found) for name, found in zip(names, ports, strict=True))
        return cls(machine, tuple(names), ports, start)

    def number(self, name: str, raw: Raw) -> float:
        """Return a value, converted to the unit of the parameter.

        Raises
        ------
        ValueError
            If the value is not allowed for the parameter.
        """
        return convert(raw, self.ports[self.names.index(name)][0], name)

    def values(self, numbers: Array | Sequence[float]) -> dict[str, dict[str, float]]:
        """Return the value of each variable that a name matches, by component and variable."""
        result: dict[str, dict[str, float]] = {}
        for name, ports, number in zip(self.names, self.ports, numbers, strict=True):
            component, _ = self.machine.prepared.assembly.system.divide(name)
            result.setdefault(component, {}).update({port.name: float(number) for port in ports})
        return result

    def machine_with(self, numbers: Array | Sequence[float], rotor: Rotor) -> Machine:
        """Return the machine with other values of the parameters, and with the given rotor."""
        plan, values = self.machine.prepared, self.values(numbers)
        parameters = {name: {**of, **values.get(name, {})} for name, of in plan.parameters.items()}
        return self.machine.with_plan(replace(plan, parameters=parameters), rotor)


def is_of_component(scenario: Scenario, name: str) -> bool:
    """Return whether a name begins with a component of the scenario's system."""
    component, variable = system_of(scenario).divide(name)
    return bool(variable) and component in {item.name for item in system_of(scenario).components}


def differences(parameters: Values, others: Values) -> dict[str, dict[str, float]]:
    """Return the items of `parameters` whose values differ from those in `others` by more than rounding."""
    return {
        component: found
        for component, values in parameters.items()
        if (found := {name: v for name, v in values.items() if not math.isclose(v, others[component][name])})
    }


def _numbers(machine: Machine, name: str) -> tuple[Port, ...]:
    system, interfaces = machine.prepared.assembly.system, machine.prepared.interfaces
    component, pattern = system.divide(name)
    ports = interfaces[component].matching(pattern)
    numbers = tuple(port for port in ports if port.causality == "parameter" and port.type == "Real")
    if not numbers:
        if ports:
            raise ValueError(f"parameter {name!r} is not allowed; it is {ports[0].kind} of type {ports[0].declared}")
        known = [port.name for port in interfaces[component].of("parameter") if port.type == "Real"]
        raise ValueError(f"parameter {name!r} is not in {component}: {suggest(pattern, known)}")
    return numbers


def _start(machine: Machine, name: str, ports: Sequence[Port]) -> float:
    component, _ = machine.prepared.assembly.system.divide(name)
    values = {port.name: machine.parameters[component][port.name] for port in ports}
    first, *rest = values.items()
    for other in rest:
        if is_pattern(name) and not math.isclose(other[1], first[1]):
            pair = " and ".join(f"{key} = {value:g}{ports[0].display_unit}" for key, value in (first, other))
            raise ValueError(f"{name} matches {pair}; fit each under its own name, or set both to the same value")
    return first[1]
