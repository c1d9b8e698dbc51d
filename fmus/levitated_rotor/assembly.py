"""Components of an assembly and their connections.

A variable of a part is called `component.variable`. Each input of a part receives its value from an output of a part (a
connection) or from an input of the assembly. An input of the assembly has the name of its shared signal. Without a
shared signal, the input has the name of the part input that it feeds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fmi_export.model import GATHERED, AssembledModel, Wiring
from fmi_export.variables import FAULT_CODE, Causality, Variable

SAMPLE_TIME = "sample_time"  # parameter of a part that samples
SLOPE = "_dot"  # ends the name of an input that is the slope of another input over a step


def variables(part: AssembledModel, causality: Causality) -> list[tuple[str, Variable]]:
    """Return the variables of a part with their names in the assembly; the shared fault code is omitted."""
    variables = part.model.interface.of(causality)
    return [(f"{part.name}.{v.name}", v) for v in variables if v.name != FAULT_CODE]


@dataclass(frozen=True)
class Composite:
    """Parts and their wiring.

    Parameters
    ----------
    parts
        Parts in the order in which they step.
    connections
        For each connected input (key), the name of the output that feeds it.
    signals
        For each shared signal (key), the names of the part inputs that it feeds.
    step_size
        Communication step of the system (s).
    jacobi
        Whether each part uses the outputs of the other parts as they were at the beginning of a step.

    Raises
    ------
    ValueError
        If no part has an output or input of a given name, or if an input has two sources.
    """

    parts: tuple[AssembledModel, ...]
    connections: Mapping[str, str]
    signals: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    step_size: float = 250e-6
    jacobi: bool = False

    def __post_init__(self) -> None:
        signalled = [target for targets in self.signals.values() for target in targets]
        twice = sorted({name for name in signalled if signalled.count(name) > 1 or name in self.connections})
        if twice:
            raise ValueError(f"inputs fed twice: {', '.join(twice)}")
        _check("output", self.connections.values(), self.outputs)
        _check("input", (*self.connections, *signalled), self.part_inputs)

    @cached_property
    def part_inputs(self) -> dict[str, Variable]:
        """Inputs of all parts in order, by name."""
        return {name: v for part in self.parts for name, v in variables(part, "input")}

    @cached_property
    def outputs(self) -> dict[str, Variable]:
        """Outputs of all parts in order, by name."""
        return {name: v for part in self.parts for name, v in variables(part, "output")}

    @cached_property
    def sources(self) -> dict[str, str]:
        """Source of each input of a part: an output of a part, or an input of the assembly."""
        signal_of = {target: signal for signal, targets in self.signals.items() for target in targets}
        return {name: self.connections.get(name, signal_of.get(name, name)) for name in self.part_inputs}

    @cached_property
    def inputs(self) -> dict[str, list[str]]:
        """Inputs of the assembly, signals first, each with the part inputs that it feeds."""
        targets: dict[str, list[str]] = {signal: [] for signal in self.signals}
        for name, source in self.sources.items():
            if name not in self.connections:
                targets.setdefault(source, []).append(name)
        return targets

    @property
    def slopes(self) -> dict[str, str]:
        """Inputs of the assembly that vary linearly within a step, each with the input that contains its slope."""
        fed = ((self.sources[name], self.sources.get(name + SLOPE, "")) for name in self.part_inputs)
        return {source: slope for source, slope in fed if source in self.inputs and slope in self.inputs}

    @property
    def sample_time(self) -> str:
        """Name of the parameter that divides steps: the sample time of a part if it alone samples, else empty."""
        sampling = [p.name for p in self.parts if p.every == 1 and SAMPLE_TIME in p.model.interface.position]
        return f"{sampling[0]}.{SAMPLE_TIME}" if len(sampling) == 1 else ""

    def named(self, part: AssembledModel, name: str) -> str:
        """Return the variable of the assembly that corresponds to a variable of a part."""
        full = f"{part.name}.{name}"
        return self.sources.get(full, full)

    def wiring(self) -> Wiring:
        """Return the wiring, which identifies the variables by their positions."""
        position = {name: k for k, name in enumerate((*self.inputs, *self.outputs))}
        return Wiring(
            sources=tuple(position[source] for source in self.sources.values()),
            ramps=tuple((position[name], position[slope]) for name, slope in self.slopes.items()),
            gathered=tuple(
                (k, GATHERED.index("largest" if v.warning else v.over_step))
                for k, v in enumerate(self.outputs.values())
                if v.warning or v.over_step in GATHERED
            ),
            sample_time=self.sample_time or self.step_size,
            jacobi=self.jacobi,
        )


def _check(kind: str, names: Any, allowed: Any) -> None:
    unknown = [name for name in names if name not in allowed]
    if unknown:
        raise ValueError(f"no part has an {kind} {', '.join(unknown)}")
