"""What moves the values of variables to and from an FMU: one FMI call for each type."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import Array as CArray
from ctypes import c_double, c_int, c_uint, c_void_p, cast
from dataclasses import dataclass
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from amb_cosim.cosim.fmu_interface import Port


@dataclass(frozen=True)
class Transfer:
    """One fmi2Set or fmi2Get call: its address, the value references, their positions among the inputs or outputs.

    Values are C doubles if `real`, and C ints otherwise.
    """

    function: int
    references: NDArray[np.uint32]
    where: NDArray[np.intp]
    real: bool


def check_status(function: str, status: int | None) -> None:
    """Raise for a status below OK as FMPy does for one above Warning; most of its methods return the status."""
    if status is not None and status < 0:
        raise FMICallException(function=function, status=status)


def address(fmu: Any, function: str) -> int:
    """Return the address of a function of an FMU's library."""
    return cast(getattr(fmu.dll, function), c_void_p).value or 0


class _Group:
    """Variables of one FMI type: value references, values as C arrays, positions among all variables."""

    def __init__(self, kind: str, ports: Sequence[tuple[int, Port]]) -> None:
        self.kind = kind
        self.setter, self.getter = f"fmi2Set{kind}", f"fmi2Get{kind}"
        self.size = len(ports)
        self.references: CArray[Any] = (c_uint * self.size)(*[port.reference for _, port in ports])
        self.buffer: CArray[Any] = ((c_double if kind == "Real" else c_int) * self.size)()
        self.view: NDArray[Any] = np.ctypeslib.as_array(self.buffer)
        self.where = np.array([position for position, _ in ports], dtype=np.intp)

    def arguments(self, fmu: Any) -> tuple[Any, ...]:
        return fmu.component, self.references, self.size, self.buffer


class Exchange:
    """Variables of an FMU that are set or read together, by one FMI call for each type."""

    def __init__(self, ports: Sequence[Port]) -> None:
        self.values = np.zeros(len(ports))
        numbered = list(enumerate(ports))
        kinds = {kind: [item for item in numbered if item[1].type == kind] for kind in _KINDS}
        self.groups = [_Group(kind, members) for kind, members in kinds.items() if members]

    def write(self, fmu: Any) -> None:
        for group in self.groups:
            group.view[:] = self.values[group.where]
            check_status(group.setter, getattr(fmu, group.setter)(*group.arguments(fmu)))

    def read(self, fmu: Any) -> None:
        for group in self.groups:
            check_status(group.getter, getattr(fmu, group.getter)(*group.arguments(fmu)))
            self.values[group.where] = group.view

    def transfers(self, fmu: Any, prefix: str) -> tuple[Transfer, ...]:
        return tuple(
            Transfer(address(fmu, prefix + g.kind), np.array(g.references, np.uint32), g.where, g.kind == "Real")
            for g in self.groups
        )


_KINDS = ("Real", "Integer", "Boolean")
