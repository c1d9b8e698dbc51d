"""Numbers without a unit that are far from a scenario's values and may therefore be meant in another unit."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.scenario.scenario import SPEED, Scenario
from amb_files.wildcards import matches

FAR = 100.0  # times the scenario's value


@dataclass(frozen=True)
class StatedValues:
    """Values that a scenario states for the variables of a machine.

    Attributes
    ----------
    scenario, settings
        The scenario, and values by name that replace its values.
    variables
        The variables of the machine; their values are not used.
    """

    scenario: Scenario
    settings: Mapping[str, Raw]
    variables: Assignments

    def refuse_far(self, name: str, value: float, label: str = "") -> None:
        """Refuse a number without a unit that is more than `FAR` times the scenario's value.

        If the scenario's value is 0, the largest value with this unit in the same component is used instead.

        Parameters
        ----------
        name
            Name or pattern `component.variable`. If an event sets the variable, the label of the event precedes it.
        value
            The number, in the unit of the variable.
        label
            Label of the event that sets the variable, if any.

        Raises
        ------
        ValueError
            If the number is too far from the scenario's value. Names that do not exist are reported elsewhere.
        """
        variable = name.removeprefix(f"{label}.")
        ports = self.ports(variable)
        unit = (ports[0].unit or "1") if ports else "1"
        if unit == "1":
            return
        reference, whose = self._magnitude(variable, unit, label), "the scenario's"
        if reference == 0.0:
            reference, whose = self._largest_alike(variable, ports[0], label), "the largest value of its kind,"
        if 0.0 < FAR * reference < abs(value):
            raise ValueError(
                f"{name} = {value:g} {unit} is {abs(value) / reference:.3g} times {whose} {reference:.4g} {unit}; add "
                f"the intended unit, such as {name}='{value:g} {unit}'"
            )

    def ports(self, variable: str) -> list[Port]:
        """Return the variables that match a name or pattern; empty if there are none."""
        try:
            return [self.variables.port(name) for name in self.variables.matching(variable)]
        except ValueError:
            return []

    def _magnitude(self, variable: str, unit: str, label: str) -> float:
        """Return the largest magnitude stated for a variable, or the magnitude of its start value if none is stated."""
        tables = [event.set for event in self.scenario.event if label and event.name == label]
        stated: dict[str, Raw] = {
            f"{component}.{name}": raw
            for table in tables or [self.scenario.parameters, self.scenario.inputs]
            for component, values in table.items()
            for name, raw in values.items()
        }
        if not label:
            stated |= {SPEED: self.scenario.Omega, **self.settings}
        matching, magnitudes = {*self.variables.matching(variable)}, []
        for name, raw in stated.items():
            with suppress(ValueError):  # the name is not part of this machine
                if matching & {*self.variables.matching(name)}:
                    magnitudes.append(abs(quantity(raw, unit, name)))
        return max(magnitudes) if magnitudes else max(abs(port.start or 0.0) for port in self.ports(variable))

    def _largest_alike(self, variable: str, port: Port, label: str) -> float:
        """Return the largest magnitude among inputs or parameters of the same component and unit."""
        component = self.variables.system.divide(variable)[0]
        interface = self.variables.interfaces.get(component)
        alike = [] if interface is None else [p for p in interface.of(port.causality) if p.unit == port.unit]
        magnitudes = [self._magnitude(f"{component}.{other.name}", port.unit or "1", label) for other in alike]
        for event in self.scenario.event:
            for pattern, raw in event.set.get(component, {}).items():
                with suppress(ValueError):
                    if any(matches(other.name, pattern) or other.name == pattern for other in alike):
                        magnitudes.append(abs(quantity(raw, port.unit or "1", pattern)))
        return max(magnitudes, default=0.0)
