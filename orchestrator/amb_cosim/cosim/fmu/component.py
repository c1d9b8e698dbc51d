"""An FMU instance for the master: arrays in, step, arrays out; `bindings` calls FMI."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_double, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from fmpy.fmi1 import FMICallException

from amb_cosim.cosim.building.loop_library import load_library
from amb_cosim.cosim.errors import FmuError
from amb_cosim.cosim.fmu.binding2 import Binding2
from amb_cosim.cosim.fmu.binding3 import Binding3
from amb_cosim.cosim.fmu.bindings import ERROR, FATAL, STATUS, WARNING, Log, address
from amb_cosim.cosim.fmu.exchange import Exchange, Transfer
from amb_cosim.cosim.fmu.exit_order import release_before_static_destructors
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from array_types import Array, Indices
from fmi_export.variables import FAULT_CODE

_serial = itertools.count()
_corrupted: set[Path] = set()  # folders of FMUs that answered Fatal here: FMI allows no further call of any instance


@dataclass(frozen=True)
class EntryPoints:
    """Addresses of an FMU instance and of the FMI functions that a step calls, for compiled code."""

    instance: int
    do_step: int
    sends: tuple[Transfer, ...]
    fetches: tuple[Transfer, ...]


class HeldState(NamedTuple):
    """A state of an FMU at an address in its process, with a number that is never reused; `forget` frees it."""

    number: int
    address: int


FmuBinding = Binding2 | Binding3
StartValues = Mapping[str, float | str | bytes]
FmuState = bytes | HeldState  # serialised, for any instance of the same FMU; or held, for the instance that returned it


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
        Names of the variables that `write` sends and `read` fetches, in the order of the arrays `inputs` and `outputs`.
    start
        Values of parameters and inputs to set before initialisation, by name, in the units of the FMU.
    every
        Number of communication steps that one step of this component spans.

    Attributes
    ----------
    stop_time
        Time (s) at which the last step of the run ends, or None; `enter` passes it to the FMU.

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
        start: StartValues,
        every: int = 1,
    ) -> None:
        self.name = name
        self._interface, self._folder = interface, folder
        self._log = Log()
        self._fmu: FmuBinding | None = None
        self._running = False  # between initialisation and an error, when the FMU may be terminated
        self._state, self._after = c_void_p(), c_void_p()
        self._held: set[HeldState] = set()
        self._memories: dict[int, Array] = {}  # by the address of a state
        self._exchanges: dict[tuple[str, ...], Exchange] = {}
        try:
            kind = Binding3 if interface.fmi == 3 else Binding2
            self._fmu = kind(interface, folder, f"{name}-{next(_serial)}", self._log)
            if (folder / "resources" / "slavemodule.txt").is_file():  # PythonFMU's, which crashes at exit otherwise
                release_before_static_destructors(folder / "binaries" / "linux64" / f"{interface.identifier}.so")
            self._set_up(inputs, outputs, start, every)
        except Exception as error:
            self.close()
            if isinstance(error, FmuError):
                raise
            raise FmuError("loading", "Error", [*self._log.explanations(), str(error)]) from error

    def reset(self, inputs: Sequence[str], outputs: Sequence[str], start: StartValues, every: int = 1) -> None:
        """Reset the FMU for another run; the arguments are the same as for the constructor.

        Raises
        ------
        FmuError
            If the FMU refuses the reset or a start value.
        """
        self._binding.prepare()
        self._free_states(self._binding)
        self._running = False
        self._call("Reset")
        self._log.messages.clear()
        self._set_up(inputs, outputs, start, every)

    def enter(self, start_time: float) -> None:
        """Begin initialisation at `start_time` (s)."""
        self._guard(None, self._binding.enter, start_time, self.stop_time)

    def leave(self) -> None:
        """End initialisation; raises `FmuError` if the FMU has reported a fault."""
        earlier = tuple(self._log.messages)
        self._call("ExitInitializationMode")
        self._running = True
        port = self._interface.ports.get(FAULT_CODE) if self._interface.reports_faults else None
        if port is not None and port.causality == "output":
            fault_code = self._exchange((port.name,))
            self._guard("Get", fault_code.read, self._binding)
            if fault_code.values[0] != 0.0:
                # Initialisation mode retries after every change, so only the last message still applies.
                raise FmuError("initialisation", f"fault {fault_code.values[0]:g}", self._log.explanations()[-1:])
        self._log.forget(earlier)  # intermediate messages of initialisation mode

    def write(self) -> None:
        """Send `inputs` to the FMU."""
        self._guard("Set", self._in.write, self._binding)

    def transform(self, laws: Sequence[tuple[float, float]]) -> None:
        """Let `write` send factor times value plus offset for each input, up to the next reset (Python loop only)."""
        factors, offsets = np.array(laws).T
        self._in.law = factors, offsets

    def read(self) -> None:
        """Fetch `outputs` from the FMU."""
        self._guard("Get", self._out.read, self._binding)

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        self._guard("DoStep", self._binding.step, time, step_size)

    def derivatives(self, unknowns: Sequence[str], knowns: Sequence[str]) -> Array:
        """Return the derivatives of unknowns with respect to knowns (FMI 2.0 only), shape (unknowns, knowns)."""
        rows, columns = ([self._interface.port(v, self.name).reference for v in names] for names in (unknowns, knowns))
        unknown = (c_uint * len(rows))(*rows)
        result = np.zeros((len(columns), len(rows)))
        for column, partials in zip(columns, result, strict=True):
            direction = byref(c_uint(column)), 1, byref(c_double(1.0))
            self._call("GetDirectionalDerivative", unknown, len(rows), *direction, np.ctypeslib.as_ctypes(partials))
        return result.T

    def save(self) -> None:
        """Store the state of the FMU, replacing the previously stored one."""
        self._call("GetFMUState", byref(self._state))

    def restore(self) -> None:
        """Restore the stored state."""
        self._call("SetFMUState", self._state)

    def hold(self) -> HeldState:
        """Return the state of the FMU in a form that survives a reset; `close` frees it."""
        pointer = c_void_p()
        self._call("GetFMUState", byref(pointer))
        return self._held_state(pointer)

    def forget(self, state: HeldState) -> None:
        """Free a held state unless it is already free."""
        if state in self._held:
            self._held.remove(state)
            self._call("FreeFMUState", byref(c_void_p(state.address)))

    def serialise(self) -> bytes:
        """Return the state of the FMU as bytes, from which `put` restores it in any instance of the same FMU."""
        state = self.hold()
        try:
            pointer = c_void_p(state.address)
            content = (self._binding.byte * self._size_of(pointer))()
            self._call("SerializeFMUState", pointer, content, len(content))
            return bytes(content)
        finally:
            self.forget(state)

    def put(self, state: FmuState, warnings: Sequence[str] = ()) -> None:
        """Restore a held or serialised state; `warnings` are the warnings logged up to that state."""
        if isinstance(state, HeldState):
            self._call("SetFMUState", c_void_p(state.address))
        else:
            pointer, content = c_void_p(), (self._binding.byte * len(state)).from_buffer_copy(state)
            self._call("DeserializeFMUState", content, len(state), byref(pointer))
            copy = self._held_state(pointer)
            try:
                self.put(copy)
            finally:
                self.forget(copy)
        self._running = True
        self._log.messages[:] = [(WARNING, text) for text in warnings]

    def _held_state(self, pointer: c_void_p) -> HeldState:
        state = HeldState(next(_serial), pointer.value or 0)
        self._held.add(state)
        return state

    def memory(self) -> Array:
        """Return the stored state as numbers that can be changed before `restore`.

        They have the layout of this project's export (`saved.c`). The last two parts are the values, in the order of
        the references, and the state; each is aligned to 16 bytes. The next `save` overwrites the numbers; `close` and
        `reset` free them.
        """
        return self._numbers(self._state)

    def present(self) -> Array:
        """Return the present state as numbers in the layout of `memory`; they are valid until the next call."""
        self._call("GetFMUState", byref(self._after))
        return self._numbers(self._after)

    def answer(self, time: float, step_size: float) -> Array:
        """Step from the stored state (times in s); return the memory after the step, which the next call overwrites."""
        self._guard(None, self._step_from_state, self._binding, time, step_size)
        return self._numbers(self._after)

    def answers(self, places: Indices, values: Array, observed: Indices, time: float, step_size: float) -> Array:
        """Step several times from the stored state, each time with other values at some indices of its memory.

        Parameters
        ----------
        places, values
            The indices, and a row of values for each step, shape (steps, places); the last row of values remains set.
        observed
            Indices of the numbers to return.
        time, step_size
            Time and size of the step (s).

        Returns
        -------
        ndarray
            The observed numbers after each step, shape (steps, observed).
        """
        fmu, library, memory = self._binding, load_library(), self._numbers(self._state)
        rows, done = np.zeros((len(values), len(observed))), 0
        if library is not None:
            calls = (address(fmu.fmu, fmu.function(name)) for name in ("SetFMUState", "GetFMUState"))
            of_fmu = fmu.fmu.component, *calls, fmu.instance, fmu.do_step, self._state, byref(self._after)
            sizes, places_at, values_at = values.shape, places.ctypes.data, values.ctypes.data
            of_rows = *sizes, places_at, values_at, len(observed), observed.ctypes.data, rows.ctypes.data
            done = library.answers(*of_fmu, time, step_size, *of_rows)
        for k in range(done, len(values)):  # with a library only after a call that fails, which now raises its error
            memory[places] = values[k]
            self.answer(time, step_size).take(observed, out=rows[k])
        return rows

    def _step_from_state(self, fmu: FmuBinding, time: float, step_size: float) -> None:
        fmu.call("SetFMUState", self._state)
        fmu.step(time, step_size)
        fmu.call("GetFMUState", byref(self._after))

    def _size_of(self, state: c_void_p) -> int:
        size = c_size_t()
        self._call("SerializedFMUStateSize", state, byref(size))
        return size.value

    def _numbers(self, state: c_void_p) -> Array:
        place = state.value or 0
        if place not in self._memories:
            numbers = (c_double * (self._size_of(state) // 8)).from_address(place)  # without the checksum's 4 bytes
            self._memories[place] = np.ctypeslib.as_array(numbers)
        return self._memories[place]

    @property
    def warnings(self) -> list[str]:
        """Warnings that the FMU has logged since its initialisation and, unless it has refused a call, its faults."""
        return self._log.warnings if self._has_refused else self._log.complaints

    def entry_points(self) -> EntryPoints:
        """Return the functions that `write`, `step` and `read` call; they are valid until `close`."""
        fmu = self._binding
        return EntryPoints(fmu.instance, fmu.do_step, self._in.transfers(fmu, "Set"), self._out.transfers(fmu, "Get"))

    def refusal(self, call: str, status: int) -> FmuError:
        """Return the error for a call (Set, Get or DoStep) that returned a status other than OK and Warning."""
        return self._refusal(self._binding.function(call), status)

    def close(self) -> None:
        """Terminate and free the instance, unless it is corrupted; this raises no error, and may be repeated."""
        fmu, self._fmu = self._fmu, None
        if fmu is None:
            return
        if self._folder in _corrupted:
            fmu.abandon()
            return
        try:
            self._free_states(fmu)
            for state in self._held:
                fmu.call("FreeFMUState", byref(c_void_p(state.address)))
            self._held.clear()
            if self._running:
                fmu.call("Terminate")
        except Exception as error:  # an FMU that has failed may refuse this too, and must be freed all the same
            self._log.add(ERROR, str(error))
        finally:
            fmu.free()

    @property
    def _binding(self) -> FmuBinding:
        assert self._fmu is not None, "the component is closed"
        return self._fmu

    def _set_up(self, inputs: Sequence[str], outputs: Sequence[str], start: StartValues, every: int) -> None:
        """Set the start values of a run, and prepare the exchange of its inputs and outputs."""
        self.every = every
        self._has_refused = False
        self.stop_time: float | None = None
        numbers = {name: value for name, value in start.items() if not isinstance(value, str | bytes)}
        self._in, self._out, initial = (self._exchange(tuple(names)) for names in (inputs, outputs, numbers))
        self.inputs, self.outputs = self._in.values, self._out.values
        initial.values[:] = list(numbers.values())
        for exchange in (initial, self._in):
            exchange.fill(numbers)
            exchange.law = None
        for name, value in start.items():
            if isinstance(value, str | bytes):
                self._guard("SetString", self._binding.send_text, self._interface.texts[name], value)
        self._guard("Set", initial.write, self._binding)

    def _exchange(self, names: tuple[str, ...]) -> Exchange:
        """Return the exchange for the variables with these names; it is reused after a reset."""
        if names not in self._exchanges:
            ports = [self._interface.port(v, self.name) for v in names]
            self._exchanges[names] = Exchange(self._binding, ports, self._interface)
        return self._exchanges[names]

    def _free_states(self, fmu: FmuBinding) -> None:
        for state in (self._state, self._after):
            if state:
                fmu.call("FreeFMUState", byref(state))
        self._state, self._after = c_void_p(), c_void_p()
        self._memories.clear()

    def _call(self, name: str, *arguments: Any) -> None:
        self._guard(None, self._binding.call, name, *arguments)

    def _guard(self, name: str | None, function: Callable[..., None], *arguments: Any) -> None:
        """Call a function; an error states `name` (Set, Get or DoStep) or, without it, the name of the FMI function."""
        try:
            function(*arguments)
        except FMICallException as error:
            call = error.function if name is None else self._binding.function(name)
            raise self._refusal(call, error.status) from error

    def _refusal(self, function: str, status: int) -> FmuError:
        self._running = self._running and 0 <= status < ERROR
        self._has_refused = True
        if status == FATAL:
            _corrupted.add(self._folder)
        end = self._binding.end_of_run(function, status)
        texts = [*self._log.explanations(), *self._binding.reasons(function, status)]
        status_text = STATUS[status] if 0 <= status < len(STATUS) else f"{status}, a status that FMI does not define"
        return FmuError(function, status_text, texts, end)
