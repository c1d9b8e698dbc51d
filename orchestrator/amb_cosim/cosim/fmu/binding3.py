"""FMI 3.0 FMUs for co-simulation: scalars and arrays are supported, but not event mode, early return or clocks.

The compiled loop calls functions with the signatures of FMI 2.0. The functions in `binding3.c` have these signatures,
but call an FMI 3.0 FMU. They receive an `_Instance` in place of an FMU instance, and the address of a `_Group` in place
of value references.
"""

from __future__ import annotations

from collections.abc import Mapping
from ctypes import (
    POINTER,
    Structure,
    addressof,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int8,
    c_int16,
    c_int32,
    c_int64,
    c_size_t,
    c_ssize_t,
    c_uint,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
    cast,
)
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from numpy.typing import NDArray

from amb_cosim.cosim.building.loop_library import load_library
from amb_cosim.cosim.fmu.bindings import DISCARD, ERROR, NO_EARLIER_STATE, Binding, Log, address, reached_text
from amb_cosim.cosim.fmu.exchange import Group, Transfer
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, TextVariable
from array_types import Array, Bools

NOTHING, ENDS, EARLY, UNFIT = range(4)  # reasons why a call failed that the FMU did not refuse


# In the order of `binding3.c`.
KINDS: dict[str, Any] = {
    "Float64": c_double,
    "Float32": c_float,
    "Int8": c_int8,
    "UInt8": c_uint8,
    "Int16": c_int16,
    "UInt16": c_uint16,
    "Int32": c_int32,
    "UInt32": c_uint32,
    "Int64": c_int64,
    "UInt64": c_uint64,
    "Boolean": c_bool,
}


class _Instance(Structure):
    _fields_ = [("instance", c_void_p), ("do_step", c_void_p), ("why", c_ssize_t), ("number", c_double)]


class _Group(Structure):
    _fields_ = [
        ("call", c_void_p),
        ("references", c_void_p),
        ("n_references", c_size_t),
        ("image", c_void_p),
        ("n_values", c_size_t),
        ("at", c_void_p),
        ("kind", c_ssize_t),
    ]


@dataclass(frozen=True, eq=False)
class _GroupTransfer(Transfer):
    """A transfer of a group of values; `only` returns the transfer of another group, with the selected values."""

    binding: Binding3
    call: str
    group: Group

    def only(self, selected: Bools) -> Transfer:
        return self.binding.transfer(self.call, self.group.only(selected))


class Binding3(Binding):
    """An instance of an FMI 3.0 FMU."""

    byte = c_uint8
    kinds: ClassVar[Mapping[str, Any]] = KINDS

    def __init__(self, interface: FmuInterface, folder: Path, name: str, log: Log) -> None:
        self.log, self._tolerance = log, interface.tolerance
        self._buffers: list[Any] = []  # what C structures point to
        self.fmu = FMU3Slave(
            guid=interface.guid,
            unzipDirectory=str(folder),
            modelIdentifier=interface.identifier,
            instanceName=name,
        )

        def receive(environment: Any, status: int, category: bytes | None, message: bytes | None) -> None:
            log.add(status, (message or b"").decode("utf-8", "replace").strip())

        self.fmu.instantiate(loggingOn=True, logMessage=receive)
        self._state = _Instance(self.fmu.component, address(self.fmu, "fmi3DoStep"))

    @staticmethod
    def function(name: str) -> str:
        return f"fmi3{name}"

    @property
    def instance(self) -> int:
        """Address that the functions in `binding3.c` receive as the instance."""
        return addressof(self._state)

    @property
    def do_step(self) -> int:
        """Address of the function in `binding3.c` that makes a step."""
        return _address_of("step_fmi3")

    def enter(self, start_time: float, stop_time: float | None = None) -> None:
        """Begin initialisation at `start_time` (s); if `stop_time` (s) is set, the run ends there."""
        tolerance, stop = ((value is not None, value or 0.0) for value in (self._tolerance, stop_time))
        self.call("EnterInitializationMode", *tolerance, start_time, *stop)

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        event, ends, early, reached = c_bool(), c_bool(), c_bool(), c_double()
        self._state.why = NOTHING
        try:
            self.call(
                "DoStep", time, step_size, NO_EARLIER_STATE, byref(event), byref(ends), byref(early), byref(reached)
            )
        finally:
            self._state.number = reached.value
        if ends or early:
            self._state.why = ENDS if ends else EARLY
            raise FMICallException(self.function("DoStep"), DISCARD)

    def reasons(self, call: str, status: int) -> list[str]:
        """Return phrases on what the FMU reported besides its status, or on a value that its variable cannot hold."""
        phrases = {
            NOTHING: [],
            ENDS: ["terminateSimulation is true"],
            EARLY: ["the FMU returned early from the step, which is not allowed"],
            UNFIT: [f"{self._state.number:.17g} does not fit into the integer type of the variable"],
        }[self._state.why]
        is_discarded = status == DISCARD and call == "fmi3DoStep" and self._state.why != ENDS
        return [*phrases, reached_text(self._state.number)] if is_discarded else phrases

    def end_of_run(self, call: str, status: int) -> float | None:
        """Return the time (s) that the FMU reached in the step in which it ended the run."""
        return float(self._state.number) if self._state.why == ENDS and call == "fmi3DoStep" else None

    def send_text(self, variable: TextVariable, value: str | bytes) -> None:
        """Set a String or Binary variable."""
        reference = (c_uint * 1)(variable.reference)
        if isinstance(value, str):
            self.call("SetString", reference, 1, (c_char_p * 1)(value.encode()), 1)
        else:
            content = cast((c_uint8 * len(value)).from_buffer_copy(value), POINTER(c_uint8))
            self.call("SetBinary", reference, 1, (c_size_t * 1)(len(value)), (POINTER(c_uint8) * 1)(content), 1)

    def kind_of(self, port: Port) -> str:
        return "Int64" if port.stored == "Enumeration" else port.stored

    def send(self, group: Group, values: Array) -> None:
        if np.issubdtype(group.dtype, np.integer):
            limits = np.iinfo(group.dtype)  # `max` is rounded up to a power of two among floats of 64 bits
            unfit = values[~((values >= limits.min) & (values < limits.max + 1.0))]
            if len(unfit):
                self._state.why, self._state.number = UNFIT, float(unfit[0])
                raise FMICallException(self.function(f"Set{group.name}"), ERROR)
        group.store(values)
        self._exchange("Set", group)

    def fetch(self, group: Group) -> NDArray[Any]:
        self._exchange("Get", group)
        return group.load()

    def transfer(self, call: str, group: Group) -> Transfer:
        """Return a call that sets or gets variables; it is valid until the instance is freed."""
        structure = _Group(
            call=address(self.fmu, self.function(call + group.name)),
            references=addressof(group.references),
            n_references=len(group.references),
            image=addressof(group.image),
            n_values=len(group.image),
            at=group.at.ctypes.data,
            kind=list(KINDS).index(group.name),
        )
        self._buffers += [structure, group]
        references = np.array([addressof(structure)], np.uintp).view(np.uint32)
        function = _address_of("send_fmi3" if call == "Set" else "fetch_fmi3")
        return _GroupTransfer(function, references, group.where, True, self, call, group)

    def _exchange(self, call: str, group: Group) -> None:
        self._state.why = NOTHING
        self.call(call + group.name, group.references, len(group.references), group.image, len(group.image))


def _address_of(function: str) -> int:
    """Return the address of a function in `binding3.c` for the compiled loop, which is in the same library."""
    return cast(getattr(load_library(), function), c_void_p).value or 0
