"""What is assembled: three models, and how they are connected.

A variable of a part is called `component.variable`. An input of a part is fed by an output of a part (a connection), or
by an input of the assembly: one that a shared signal feeds has the signal's name, any other its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fmi_export.model import Model
from fmi_export.variables import FAULT_CODE, Causality, Variable

ROLES = ("controller", "actuator", "plant")  # of the parts, in the order in which they step


@dataclass(frozen=True)
class Part:
    """A model and the name of the component that it is."""

    name: str
    model: Model

    def of(self, causality: Causality) -> list[tuple[str, Variable]]:
        """Return variables by their names in the assembly; without the fault code, which the parts share."""
        found = self.model.interface.of(causality)
        return [(f"{self.name}.{v.name}", v) for v in found if v.name != FAULT_CODE]


@dataclass(frozen=True)
class Assembly:
    """Three parts and their wiring.

    Parameters
    ----------
    parts
        Controller, actuator and plant.
    connections
        Output that feeds an input of a part, by that input.
    signals
        Inputs of parts that a shared signal feeds, by its name.

    Raises
    ------
    ValueError
        If a name is that of no variable of this kind, or an input is fed twice.
    """

    parts: tuple[Part, Part, Part]
    connections: Mapping[str, str]
    signals: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        signalled = [target for targets in self.signals.values() for target in targets]
        twice = sorted({name for name in signalled if signalled.count(name) > 1 or name in self.connections})
        if twice:
            raise ValueError(f"inputs fed twice: {', '.join(twice)}")
        _check("output", self.connections.values(), self.outputs)
        _check("input", (*self.connections, *signalled), self.part_inputs)

    @cached_property
    def part_inputs(self) -> dict[str, Variable]:
        """Inputs of all parts in turn, by name."""
        return {name: v for part in self.parts for name, v in part.of("input")}

    @cached_property
    def outputs(self) -> dict[str, Variable]:
        """Outputs of all parts in turn, by name."""
        return {name: v for part in self.parts for name, v in part.of("output")}

    @cached_property
    def sources(self) -> dict[str, str]:
        """What feeds each input of a part: an output of a part, or an input of the assembly."""
        signal_of = {target: signal for signal, targets in self.signals.items() for target in targets}
        return {name: self.connections.get(name, signal_of.get(name, name)) for name in self.part_inputs}

    @cached_property
    def inputs(self) -> dict[str, list[str]]:
        """Inputs of the assembly, signals first, and the inputs of parts that each feeds."""
        targets: dict[str, list[str]] = {signal: [] for signal in self.signals}
        for name, source in self.sources.items():
            if name not in self.connections:
                targets.setdefault(source, []).append(name)
        return targets

    @property
    def slope(self) -> str:
        """The input of the assembly that is the slope of the speed over a step; empty where there is none."""
        plant = self.parts[-1].name
        speed, slope = (self.sources[f"{plant}.{name}"] for name in ("Omega", "Omega_dot"))
        return slope if speed in self.inputs and slope in self.inputs else ""

    @property
    def speed_inputs(self) -> list[str]:
        """Inputs of parts that follow the speed within a step: all that the plant's speed feeds, if it has a slope."""
        return self.inputs[self.sources[f"{self.parts[-1].name}.Omega"]] if self.slope else []

    def named(self, part: Part, name: str) -> str:
        """Return the variable of the assembly that has the value of a variable of a part."""
        full = f"{part.name}.{name}"
        return self.sources.get(full, full)

    def layout(self) -> dict[str, Any]:
        """Return the same in types of JSON, for `model.model_from`."""
        return {
            "parts": {role: [part.name, part.model.layout] for role, part in zip(ROLES, self.parts, strict=True)},
            "connections": dict(self.connections),
            "signals": {name: list(targets) for name, targets in self.signals.items()},
        }


def _check(kind: str, names: Any, known: Any) -> None:
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"no part has an {kind} {', '.join(unknown)}")
