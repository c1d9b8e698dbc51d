"""Finds and checks the FMUs of a system's components, and lays out their signals for the master."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.fmu.fmu_libraries import check_libraries
from amb_cosim.cosim.fmu.fmus import Fmu, ingredients, provide
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.differences import described
from amb_cosim.cosim.system.replacement import fitted
from amb_cosim.cosim.system.signal_map import SignalMap
from amb_cosim.cosim.system.system import System
from amb_files.checks import errors_in


@dataclass(frozen=True)
class Assembly:
    """A system with the FMUs of its components, checked against their interfaces.

    `options` are the options with which its models were made; see `model_source`.
    """

    system: System
    fmus: Mapping[str, Fmu]
    interfaces: Mapping[str, FmuInterface]
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def flavour(self) -> str:
        """The flavour of all FMUs, or `mixed`."""
        flavours = {fmu.flavour for fmu in self.fmus.values()}
        return flavours.pop() if len(flavours) == 1 else "mixed"

    @property
    def from_elsewhere(self) -> list[str]:
        """The components whose FMUs are files."""
        return [name for name, fmu in self.fmus.items() if fmu.flavour == "file"]

    @cached_property
    def sources(self) -> dict[str, tuple[str, Any]]:
        """Name and content (JSON data) of each file or object that FMUs are made from, by kind, such as `FMU of motor`.

        A digest represents the content of a file other than TOML.
        """
        result = {}
        for c in self.system.components:
            for kind, source in ingredients(c.fmu, **self.options).items():
                is_local = kind in ("FMU", "file")
                result[f"{kind} of {c.name}" if is_local else kind] = described(source)
        return result

    def assignments(self) -> Assignments:
        """Return the values of the system's parameters, to which further values can be added."""
        return self._assignments.copy()

    def wiring(self, exogenous: Iterable[str], recorded: Iterable[str] = ()) -> SignalMap:
        """Lay out all signals for a master; runs that differ only in values share the layout.

        Parameters
        ----------
        exogenous
            Shared signals by their names, and other inputs and tunable parameters (`component.variable`) that a
            schedule sets.
        recorded
            Outputs to fetch even if they are not connected.
        """
        key = tuple(exogenous), tuple(recorded)
        if key not in self._wirings:
            self._wirings[key] = _layout(self.system, self.interfaces, *key)
        return self._wirings[key]

    @cached_property
    def _wirings(self) -> dict[tuple[tuple[str, ...], tuple[str, ...]], SignalMap]:
        return {}

    @cached_property
    def _assignments(self) -> Assignments:
        values = Assignments(self.system, self.interfaces)
        with errors_in(f"system {self.system.name}"):
            values.set_parameters(self.system.parameters)
        return values


def assemble(system: System, flavour: Flavour = "native", **options: Any) -> Assembly:
    """Find the FMUs of a system and check its connections.

    Parameters
    ----------
    system
        Components and connections.
    flavour
        Flavour of the models to build; FMU files are used unchanged.
    options
        Options of models; see `model_source`.

    Raises
    ------
    ValueError
        If an FMU is not available, or the system does not match the interfaces.
    """
    fmus = {c.name: provide(c.fmu, flavour, **options) for c in system.components}
    interfaces: Mapping[str, FmuInterface] = {c: _interface(fmu, c) for c, fmu in fmus.items()}
    system, interfaces = fitted(system, interfaces, lambda c: _interface(provide(c.fmu, flavour, **options), c.name))
    return Assembly(system, fmus, interfaces, options)


def _interface(fmu: Fmu, component: str) -> FmuInterface:
    """Return the interface of an FMU after checking its libraries."""
    interface = read_interface(fmu.folder, component, fmu.path)
    check_libraries(fmu.folder, interface, f"{component}: {fmu.path}")
    return interface


def _layout(
    system: System, interfaces: Mapping[str, FmuInterface], exogenous: Collection[str], recorded: Collection[str]
) -> SignalMap:
    """Return the layout of a system's signals for a master; see `Assembly.wiring`."""
    fetched = {link.source for link in system.connections} | set(recorded)
    # Reals first: they are then a block of the value array, which an FMU can write itself.
    outputs = {
        name: [p.name for p in sorted(interfaces[name].of("output"), key=_not_real) if f"{name}.{p.name}" in fetched]
        for name in (c.name for c in system.components)
    }
    source_of = {target: source.removeprefix("signal ") for source, target in system.feeds()}
    source_of |= {name: name for name in exogenous if system.signal(name) is None}
    inputs = {
        c.name: [p.name for p in _receiving(interfaces[c.name]) if f"{c.name}.{p.name}" in source_of]
        for c in system.components
    }
    names = [
        *exogenous,
        *(f"{name}.{variable}" for name, variables in outputs.items() for variable in variables),
    ]
    position = {name: i for i, name in enumerate(names)}
    sources = tuple(
        np.array([position[source_of[f"{name}.{variable}"]] for variable in variables], dtype=np.intp)
        for name, variables in inputs.items()
    )
    depends_on: list[tuple[int, ...]] = [() for _ in exogenous]
    for component, variables in outputs.items():
        for variable in variables:
            inputs_read = [f"{component}.{u}" for u in interfaces[component].ports[variable].depends_on]
            depends_on.append(tuple(position[source_of[end]] for end in inputs_read if end in source_of))
    weights = tuple(
        np.array([_weight(system, source_of[f"{name}.{u}"], interfaces[name], interfaces) for u in variables])
        for name, variables in inputs.items()
    )
    return SignalMap(tuple(names), len(exogenous), sources, tuple(depends_on), weights, inputs, outputs)


def _weight(system: System, source: str, target: FmuInterface, interfaces: Mapping[str, FmuInterface]) -> float:
    """Return the weight that the value of a source at the end of a step has for an input of `target`.

    See `iteration`. Exogenous inputs are constant over the step.
    """
    port = system.port(source, interfaces) if system.signal(source) is None else None
    sample_time = target.ports.get("sample_time")
    is_sampled = sample_time is not None and sample_time.causality == "parameter"
    if port is None or port.causality != "output" or port.type != "Real" or is_sampled:
        return 0.0
    return 1.0 if port.depends_on else 0.5


def _receiving(interface: FmuInterface) -> tuple[Port, ...]:
    """Return the variables that may be set during a run."""
    return (*interface.of("input"), *(p for p in interface.of("parameter") if p.variability == "tunable"))


def _not_real(port: Port) -> bool:
    return port.type != "Real"
