"""One FMU instance as the master uses it: arrays in, step, arrays out. FMI functions are called here alone."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from contextlib import suppress
from ctypes import byref, c_char, c_double, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException, printLogMessage
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Terminated,
    fmi2True,
)
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from amb_cosim.cosim.errors import FmuError
from amb_cosim.cosim.exchange import Exchange, Transfer, address, check_status
from amb_cosim.cosim.exit_order import release_before_static_destructors
from amb_cosim.cosim.fmu_interface import FmuInterface

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")

WARNING, DISCARD, ERROR = (STATUS.index(name) for name in ("Warning", "Discard", "Error"))
MOST_WARNINGS = 100  # of a component that are kept

_logs: dict[str, list[tuple[int, str]]] = {}  # status and text of the messages of each instance
_serial = itertools.count()


@dataclass(frozen=True)
class EntryPoints:
    """Addresses of an FMU instance and of the FMI functions that a step calls, for compiled code."""

    instance: int
    do_step: int
    sends: tuple[Transfer, ...]
    fetches: tuple[Transfer, ...]


@dataclass(frozen=True, eq=False)
class HeldState:
    """A state of an FMU that lies in the memory of its instance; `FmuComponent.forget` frees it."""

    pointer: c_void_p


State = bytes | HeldState  # serialised, for any instance of the same FMU, or held for the one that it is of


class FmuComponent:
    """A loaded FMU instance.

    Parameters
    ----------
    name
        Name of the component.
    folder
        Where the FMU is extracted.
    interface
        Its interface.
    inputs, outputs
        Names of the variables that `write` sends and `read` fetches, in the order of the arrays `inputs` and
        `outputs` of the object.
    start
        Values of parameters and inputs that are set before initialisation, by name, in the units of the FMU.
    every
        Number of communication steps that one step of this component spans.

    Raises
    ------
    FmuError
        If the FMU cannot be loaded or refuses a start value.
    """

    def __init__(
        self,
        name: str,
        folder: Path,
        interface: FmuInterface,
        inputs: Sequence[str],
        outputs: Sequence[str],
        start: Mapping[str, float],
        every: int = 1,
    ) -> None:
        self.name = name
        self._interface = interface
        self._instance_name = f"{name}-{next(_serial)}"
        self._log = _logs.setdefault(self._instance_name, [])
        self._fmu: Any = None
        self._running = False  # between initialisation and an error, when fmi2Terminate may be called
        self._state, self._after = c_void_p(), c_void_p()
        self._held: set[HeldState] = set()
        self._memories: dict[int, NDArray[np.float64]] = {}  # by the address of a state
        self._exchanges: dict[tuple[str, ...], Exchange] = {}
        try:
            self._fmu = FMU2Slave(
                guid=interface.guid,
                unzipDirectory=str(folder),
                modelIdentifier=interface.identifier,
                instanceName=self._instance_name,
            )
            _take_messages()
            self._fmu.instantiate(callbacks=_callbacks(), loggingOn=True)
            if (folder / "resources" / "slavemodule.txt").is_file():  # PythonFMU's, which crashes at exit otherwise
                release_before_static_destructors(folder / "binaries" / "linux64" / f"{interface.identifier}.so")
            self._set_up(inputs, outputs, start, every)
        except Exception as error:
            self.close()
            if isinstance(error, FmuError):
                raise
            raise FmuError("loading", "Error", [*self._said(), str(error)]) from error

    def reset(self, inputs: Sequence[str], outputs: Sequence[str], start: Mapping[str, float], every: int = 1) -> None:
        """Reset the FMU for another run; the arguments are those of the constructor.

        Raises
        ------
        FmuError
            If the FMU refuses to be reset, or a start value.
        """
        _take_messages()
        self._free_states(self._fmu)
        self._running = False
        self._call("fmi2Reset", self._fmu.reset)
        self._log.clear()
        self._set_up(inputs, outputs, start, every)

    def enter(self, start_time: float) -> None:
        """Begin initialisation at `start_time` (s)."""
        self._call("fmi2SetupExperiment", self._fmu.setupExperiment, None, start_time)
        self._call("fmi2EnterInitializationMode", self._fmu.enterInitializationMode)

    def leave(self) -> None:
        """End initialisation; raises `FmuError` if the FMU has reported a fault."""
        before = len(self._log)
        self._call("fmi2ExitInitializationMode", self._fmu.exitInitializationMode)
        self._running = True
        port = self._interface.ports.get("fault_code")
        if port is not None and port.causality == "output":
            fault = self._exchange((port.name,))
            self._call("fmi2Get", fault.read, self._fmu)
            if fault.values[0] != 0.0:
                # Initialisation mode tries again after every change, so only what was said last still holds.
                raise FmuError("initialisation", f"fault {fault.values[0]:g}", self._said()[-1:])
        del self._log[:before]  # what initialisation mode said on the way

    def write(self) -> None:
        """Send `inputs` to the FMU."""
        self._call("fmi2Set", self._in.write, self._fmu)

    def read(self) -> None:
        """Fetch `outputs` from the FMU."""
        self._call("fmi2Get", self._out.read, self._fmu)

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        self._call("fmi2DoStep", self._fmu.fmi2DoStep, self._fmu.component, time, step_size, fmi2True)

    def derivatives(self, unknowns: Sequence[str], knowns: Sequence[str]) -> NDArray[np.float64]:
        """Return the derivatives of unknowns by knowns, shape (unknowns, knowns), as the FMU gives them."""
        rows, columns = ([self._interface.port(v, self.name).reference for v in names] for names in (unknowns, knowns))
        asked, ask = (c_uint * len(rows))(*rows), "fmi2GetDirectionalDerivative"
        found = np.zeros((len(columns), len(rows)))
        for column, answer in zip(columns, found, strict=True):
            known = byref(c_uint(column)), 1, byref(c_double(1.0))
            given = self._fmu.component, asked, len(rows), *known, np.ctypeslib.as_ctypes(answer)
            self._call(ask, getattr(self._fmu, ask), *given)
        return found.T

    def save(self) -> None:
        """Keep the state of the FMU, in place of the one that was kept before."""
        self._call("fmi2GetFMUstate", self._fmu.fmi2GetFMUstate, self._fmu.component, byref(self._state))

    def restore(self) -> None:
        """Bring back the state that was kept."""
        self._call("fmi2SetFMUstate", self._fmu.fmi2SetFMUstate, self._fmu.component, self._state)

    def hold(self) -> HeldState:
        """Return the state of the FMU, which a reset leaves as it is, and `close` frees."""
        state = HeldState(c_void_p())
        self._call("fmi2GetFMUstate", self._fmu.fmi2GetFMUstate, self._fmu.component, byref(state.pointer))
        self._held.add(state)
        return state

    def forget(self, state: HeldState) -> None:
        """Free a state that is held, if that has not happened."""
        if state in self._held:
            self._held.remove(state)
            self._call("fmi2FreeFMUstate", self._fmu.fmi2FreeFMUstate, self._fmu.component, byref(state.pointer))

    def serialise(self) -> bytes:
        """Return the state of the FMU as bytes, which `put` takes in any instance of the same FMU."""
        state, size = self.hold(), c_size_t()
        try:
            whole = self._fmu.component, state.pointer
            self._call("fmi2SerializedFMUstateSize", self._fmu.fmi2SerializedFMUstateSize, *whole, byref(size))
            content = (c_char * size.value)()
            self._call("fmi2SerializeFMUstate", self._fmu.fmi2SerializeFMUstate, *whole, content, size.value)
            return bytes(content)
        finally:
            self.forget(state)

    def put(self, state: State, warnings: Sequence[str] = ()) -> None:
        """Bring the FMU into a state, held or serialised; `warnings` are what it had logged as such until then."""
        if isinstance(state, HeldState):
            self._call("fmi2SetFMUstate", self._fmu.fmi2SetFMUstate, self._fmu.component, state.pointer)
        else:
            copy, content = HeldState(c_void_p()), (c_char * len(state)).from_buffer_copy(state)
            given = self._fmu.component, content, len(state), byref(copy.pointer)
            self._call("fmi2DeSerializeFMUstate", self._fmu.fmi2DeSerializeFMUstate, *given)
            self._held.add(copy)
            try:
                self.put(copy)
            finally:
                self.forget(copy)
        self._running = True
        self._log[:] = [(WARNING, text) for text in warnings]

    def memory(self) -> NDArray[np.float64]:
        """Return the state that was kept, as numbers that can be changed before `restore`.

        They are what an FMU of this project's export keeps (`saved.c`): its values, in the order of the references, and
        its state end them, each from a multiple of 16 bytes on. The next `save` changes them, `close` and `reset` free
        them.
        """
        return self._numbers(self._state)

    def answer(self, time: float, step_size: float) -> NDArray[np.float64]:
        """Step from the state that was kept (s), and return the memory after it, which the next answer changes."""
        self.restore()
        self.step(time, step_size)
        self._call("fmi2GetFMUstate", self._fmu.fmi2GetFMUstate, self._fmu.component, byref(self._after))
        return self._numbers(self._after)

    def _numbers(self, state: c_void_p) -> NDArray[np.float64]:
        place = state.value or 0
        if place not in self._memories:
            size, measure = c_size_t(), self._fmu.fmi2SerializedFMUstateSize
            self._call("fmi2SerializedFMUstateSize", measure, self._fmu.component, state, byref(size))
            numbers = (c_double * (size.value // 8)).from_address(place)  # without the checksum's 4 bytes
            self._memories[place] = np.ctypeslib.as_array(numbers)
        return self._memories[place]

    @property
    def warnings(self) -> list[str]:
        """What the FMU logged as a warning since the end of its initialisation."""
        return [text for status, text in self._log if status == WARNING]

    def entry_points(self) -> EntryPoints:
        """Return the functions that `write`, `step` and `read` call; valid until `close`."""
        return EntryPoints(
            instance=int(self._fmu.component),
            do_step=address(self._fmu, "fmi2DoStep"),
            sends=self._in.transfers(self._fmu, "fmi2Set"),
            fetches=self._out.transfers(self._fmu, "fmi2Get"),
        )

    def refusal(self, call: str, status: int) -> FmuError:
        """Return the error for a call that the FMU answered with a status other than OK and Warning."""
        self._running = self._running and 0 <= status < ERROR
        said = self._said()
        if status == DISCARD and call == "fmi2DoStep" and self._ended():
            said.append("with fmi2Terminated the FMU ends the simulation")
        known = STATUS[status] if 0 <= status < len(STATUS) else f"{status}, a status that FMI does not have"
        return FmuError(call, known, said)

    def close(self) -> None:
        """Terminate and free the instance; calling it again does nothing, and it never raises."""
        fmu, self._fmu = self._fmu, None
        _logs.pop(self._instance_name, None)
        if fmu is None or not fmu.component:
            return
        try:
            self._free_states(fmu)
            self._free_held(fmu)
            if self._running:
                fmu.terminate()
        except Exception as error:  # an FMU that has failed may refuse this too, and must be freed all the same
            self._log.append((ERROR, str(error)))
        finally:
            fmu.freeInstance()

    def _set_up(self, inputs: Sequence[str], outputs: Sequence[str], start: Mapping[str, float], every: int) -> None:
        """Set the start values of a run, and say what it exchanges."""
        self.every = every
        self._in, self._out, initial = (self._exchange(tuple(names)) for names in (inputs, outputs, start))
        self.inputs, self.outputs = self._in.values, self._out.values
        initial.values[:] = list(start.values())
        self._call("fmi2Set", initial.write, self._fmu)

    def _exchange(self, names: tuple[str, ...]) -> Exchange:
        """Return what moves the variables of these names; a run after a reset has those of the run before."""
        if names not in self._exchanges:
            self._exchanges[names] = Exchange([self._interface.port(v, self.name) for v in names])
        return self._exchanges[names]

    def _free_held(self, fmu: Any) -> None:
        for state in self._held:
            fmu.fmi2FreeFMUstate(fmu.component, byref(state.pointer))
        self._held.clear()

    def _free_states(self, fmu: Any) -> None:
        for state in (self._state, self._after):
            if state:
                fmu.fmi2FreeFMUstate(fmu.component, byref(state))
        self._state, self._after = c_void_p(), c_void_p()
        self._memories.clear()

    def _said(self) -> list[str]:
        """Return what the FMU logged, without warnings if there is more than those."""
        return [text for status, text in self._log if status != WARNING] or self.warnings

    def _ended(self) -> bool:
        """Return whether the FMU discarded a step because it wants no other."""
        with suppress(Exception):  # a question that an FMU need not answer
            return bool(self._fmu.getBooleanStatus(fmi2Terminated))
        return False

    def _call(self, name: str, function: Any, *arguments: Any) -> None:
        try:
            check_status(name, function(*arguments))
        except FMICallException as error:
            raise self.refusal(name, error.status) from error


def _receive(environment: Any, instance: bytes, status: int, category: bytes, message: bytes) -> None:
    """Append a log message to the log of its component.

    An FMU of PythonFMU hands it to the logger of the instance made last, and names its own instance in the text.
    """
    text = message.decode("utf-8", "replace").strip()
    name, _, rest = text.partition(": ")
    if name not in _logs:
        name, rest = (instance or b"").decode("utf-8", "replace"), text
    if name not in _logs:
        printLogMessage(environment, instance, status, category, message)
    elif status != WARNING or len(_logs[name]) < MOST_WARNINGS:
        _logs[name].append((status, rest))


_LOGGER = fmi2CallbackLoggerTYPE(_receive)


@cache
def _callbacks() -> fmi2CallbackFunctions:
    """Return the callbacks of all components; fmpy has one logger a process, so instance names separate messages."""
    callbacks = fmi2CallbackFunctions()
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    return callbacks


def _take_messages() -> None:
    """Let the logger of fmpy call `_receive`: whoever used fmpy last has his own there, which may be gone by now."""
    callbacks = _callbacks()
    callbacks.logger = _LOGGER
    addLoggerProxy(byref(callbacks))
