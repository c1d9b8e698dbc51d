"""Finds and checks the FMUs of a system's components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmu_libraries import check_libraries
from amb_cosim.cosim.fmu.fmus import Fmu, provide
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.replacement import fitted
from amb_cosim.cosim.system.system import MasterLayout, System


@dataclass(frozen=True)
class Assembly:
    """A system with the FMUs of its components, checked against their interfaces.

    `options` are those that its models were made with, see `model_source`.
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

    def assignments(self) -> Assignments:
        """Return the values of the system's parameters, for additions."""
        return self._assignments.copy()

    def wiring(self, exogenous: Iterable[str], recorded: Iterable[str]) -> MasterLayout:
        """Lay out all signals for a master, see `System.wiring`; runs that differ only in values share it."""
        key = tuple(exogenous), tuple(recorded)
        if key not in self._wirings:
            self._wirings[key] = self.system.wiring(self.interfaces, *key)
        return self._wirings[key]

    @cached_property
    def _wirings(self) -> dict[tuple[tuple[str, ...], tuple[str, ...]], MasterLayout]:
        return {}

    @cached_property
    def _assignments(self) -> Assignments:
        values = Assignments(self.system, self.interfaces)
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
        Options of models, see `model_source`.

    Raises
    ------
    ValueError
        If an FMU is not available, or the system does not match the interfaces.
    """
    fmus = {c.name: provide(c.fmu, flavour, **options) for c in system.components}
    interfaces = {c: _interface(fmu, c) for c, fmu in fmus.items()}
    system, fitting = fitted(system, interfaces, lambda c: _interface(provide(c.fmu, flavour, **options), c.name))
    return Assembly(system, fmus, fitting, options)


def _interface(fmu: Fmu, component: str) -> FmuInterface:
    """Return the interface of an FMU, whose libraries have been checked."""
    interface = read_interface(fmu.folder, component, fmu.path)
    check_libraries(fmu.folder, interface, f"{component}: {fmu.path}")
    return interface
