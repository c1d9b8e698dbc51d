"""What moves the values of variables to and from an FMU: one FMI call for each type.

`bindings` has the calls themselves, for each version of FMI.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import Array as CArray
from ctypes import c_uint
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port


class Kind(NamedTuple):
    """How FMI stores the values of a type: as which type of C, and the limits (the upper one excluded) of what fits."""

    ctype: Any
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class Transfer:
    """One call that sets or gets values, for compiled code.

    It is called as fmi2SetReal is. `references` is what it gets to know the variables by: their value references, in
    FMI 2.0. `where` are their positions among the inputs or outputs. Values are C doubles if `real`, C ints otherwise.
    """

    function: int
    references: NDArray[np.uint32]
    where: NDArray[np.intp]
    real: bool

    def only(self, kept: NDArray[np.bool_]) -> Transfer:
        """Return a transfer of those values alone that are `kept`."""
        return replace(self, references=self.references[kept], where=self.where[kept])


class Group:
    """Variables of one type that go in one call.

    Attributes
    ----------
    references
        Value references; an array has one.
    image
        Their values as the FMU stores them, those of arrays whole.
    at, where
        Positions of the variables that are exchanged, in the image and among all that the exchange moves.
    """

    def __init__(self, name: str, kind: Kind, ports: Sequence[tuple[int, Port]], interface: FmuInterface) -> None:
        self.name, self.kind, self._ports, self._interface = name, kind, ports, interface
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
        self._rest = [(k, element) for k, element in elements if k not in at]
        self.references: CArray[Any] = (c_uint * len(references))(*references)
        self.image: CArray[Any] = (kind.ctype * size)()
        self._view: NDArray[Any] = np.ctypeslib.as_array(self.image)
        self.at = np.array(at, np.intp)
        self.where = np.array([position for position, _ in ports], np.intp)

    def fill(self, values: Mapping[str, float]) -> None:
        """Give the elements of arrays that are not exchanged these values, by name, or their start values."""
        for k, port in self._rest:
            self._view[k] = values.get(port.name, port.start or 0.0)

    def store(self, values: NDArray[np.float64]) -> float | None:
        """Put values into the image; return one that the type cannot hold, in place of that."""
        if self.kind.limits is not None:
            low, high = self.kind.limits
            unfit = values[~((values >= low) & (values < high))]
            if len(unfit):
                return float(unfit[0])
        self._view[self.at] = values
        return None

    def load(self) -> NDArray[Any]:
        """Return the values of the image that are exchanged."""
        return self._view[self.at]

    def only(self, kept: NDArray[np.bool_]) -> Group:
        """Return a group of those variables alone that are `kept`."""
        ports = [item for item, keep in zip(self._ports, kept, strict=True) if keep]
        return Group(self.name, self.kind, ports, self._interface)


class Exchanging(Protocol):
    """What an exchange needs of a binding."""

    kinds: ClassVar[Mapping[str, Kind]]

    def kind_of(self, port: Port) -> str: ...
    def send(self, group: Group, values: NDArray[np.float64]) -> None: ...
    def fetch(self, group: Group) -> NDArray[Any]: ...
    def transfer(self, call: str, group: Group) -> Transfer: ...


class Exchange:
    """Variables of an FMU that are set or read together, by one FMI call for each type."""

    def __init__(self, fmu: Exchanging, ports: Sequence[Port], interface: FmuInterface) -> None:
        self.values = np.zeros(len(ports))
        self.law: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None  # factors and offsets of what is set
        of_kind: dict[str, list[tuple[int, Port]]] = {name: [] for name in fmu.kinds}
        for item in enumerate(ports):
            of_kind[fmu.kind_of(item[1])].append(item)
        self.groups = [Group(name, fmu.kinds[name], of_one, interface) for name, of_one in of_kind.items() if of_one]

    def fill(self, values: Mapping[str, float]) -> None:
        """Give elements of arrays that are not exchanged these values, by name, or their start values."""
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
