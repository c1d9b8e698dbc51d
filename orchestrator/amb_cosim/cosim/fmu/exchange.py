"""Exchange of variables with an FMU: one FMI call per type.

`bindings` contains the calls themselves, for each version of FMI.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import Array as CArray
from ctypes import c_uint
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from array_types import Array, Bools, Indices


@dataclass(frozen=True)
class Transfer:
    """A call that sets or gets values, for compiled code.

    The call has the arguments of fmi2SetReal. `references` identify the variables; in FMI 2.0, they are value
    references. `where` are their positions among the inputs or outputs. Values are C doubles if `real` is set, and C
    ints otherwise.
    """

    function: int
    references: NDArray[np.uint32]
    where: Indices
    real: bool

    def only(self, selected: Bools) -> Transfer:
        """Return a transfer of the `selected` values."""
        return replace(self, references=self.references[selected], where=self.where[selected])


class Group:
    """Variables of the same type, exchanged in a single call.

    Attributes
    ----------
    references
        Value references, one per array.
    image
        The values, of type `dtype`, as the FMU stores them; they include complete arrays.
    at, where
        Positions of the exchanged variables in the image, and among all exchanged values.
    """

    def __init__(self, name: str, ctype: Any, ports: Sequence[tuple[int, Port]], interface: FmuInterface) -> None:
        self.name, self._ctype, self._ports, self._interface = name, ctype, ports, interface
        begins: dict[int, int] = {}
        references, at, size = [], [], 0
        for _, port in ports:
            if port.size == 1 or port.reference not in begins:
                begins[port.reference] = size
                references.append(port.reference)
                size += port.size
            at.append(begins[port.reference] + port.element)
        arrays = {port.reference: interface.whole(port) for _, port in ports if port.size > 1}
        elements = ((begins[r] + element.element, element) for r, whole in arrays.items() for element in whole)
        self._unexchanged = [(k, element) for k, element in elements if k not in at]
        self.references: CArray[Any] = (c_uint * len(references))(*references)
        self.image: CArray[Any] = (ctype * size)()
        self._view: NDArray[Any] = np.ctypeslib.as_array(self.image)
        self.dtype = self._view.dtype
        self.at = np.array(at, np.intp)
        self.where = np.array([position for position, _ in ports], np.intp)

    def fill(self, values: Mapping[str, float]) -> None:
        """Set array elements that are not exchanged to their values in `values` (by name), or else to start values."""
        for k, port in self._unexchanged:
            self._view[k] = values.get(port.name, port.start or 0.0)

    def store(self, values: Array) -> None:
        """Write values to the image."""
        self._view[self.at] = values

    def load(self) -> NDArray[Any]:
        """Return the exchanged values in the image."""
        return self._view[self.at]

    def only(self, selected: Bools) -> Group:
        """Return a group of the `selected` variables."""
        ports = [port for port, keep in zip(self._ports, selected, strict=True) if keep]
        return Group(self.name, self._ctype, ports, self._interface)


class Exchanging(Protocol):
    """The part of a binding that an exchange uses; `kinds` maps type names in FMI functions to C types."""

    kinds: ClassVar[Mapping[str, Any]]

    def kind_of(self, port: Port) -> str: ...
    def send(self, group: Group, values: Array) -> None: ...
    def fetch(self, group: Group) -> NDArray[Any]: ...
    def transfer(self, call: str, group: Group) -> Transfer: ...


class Exchange:
    """Variables of an FMU that are set or read together, by one FMI call for each type."""

    def __init__(self, fmu: Exchanging, ports: Sequence[Port], interface: FmuInterface) -> None:
        self.values = np.zeros(len(ports))
        self.law: tuple[Array, Array] | None = None  # factors and offsets that `write` applies
        of_kind: dict[str, list[tuple[int, Port]]] = {name: [] for name in fmu.kinds}
        for position, port in enumerate(ports):
            of_kind[fmu.kind_of(port)].append((position, port))
        self.groups = [Group(name, fmu.kinds[name], chosen, interface) for name, chosen in of_kind.items() if chosen]

    def fill(self, values: Mapping[str, float]) -> None:
        for group in self.groups:
            group.fill(values)

    def write(self, fmu: Exchanging) -> None:
        values = self.values if self.law is None else self.law[0] * self.values + self.law[1]
        for group in self.groups:
            fmu.send(group, values[group.where])

    def read(self, fmu: Exchanging) -> None:
        for group in self.groups:
            self.values[group.where] = fmu.fetch(group)

    def transfers(self, fmu: Exchanging, call: str) -> tuple[Transfer, ...]:
        return tuple(fmu.transfer(call, group) for group in self.groups)
