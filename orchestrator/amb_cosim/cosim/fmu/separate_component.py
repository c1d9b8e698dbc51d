"""An FMU instance in a process of its own, for FMUs that cannot share one (`process_sharing`).

Each call is a request to that process, `component_process`, which answers with a result or an error. The compiled loop
cannot call it.
"""

from __future__ import annotations

import pickle
import subprocess
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from ctypes import c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.child_process import child_process, end_group, how_it_ended
from amb_cosim.cosim.basics.errors import ProcessFailed
from amb_cosim.cosim.fmu.component import FmuComponent, FmuState, HeldState, StartValues
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface

END_TIME = 10.0  # s in which a process that no longer answers has to end


class SeparateComponent(FmuComponent):
    """An `FmuComponent` in a process of its own; arguments and errors are the same, and `ProcessFailed`."""

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
        self._numbers_of_states: dict[HeldState, int] = {}
        self._stack = ExitStack()
        arguments = name, folder, interface, tuple(inputs), tuple(outputs), dict(start), every
        self._process = self._stack.enter_context(child_process("fmu.component_process", arguments))
        try:
            self._answer()
        except BaseException:
            self._stack.close()
            raise
        self._prepare(inputs, outputs, every)

    def _prepare(self, inputs: Sequence[str], outputs: Sequence[str], every: int) -> None:
        self.every = every
        self.stop_time = None
        self.inputs, self.outputs = np.zeros(len(inputs)), np.zeros(len(outputs))

    def reset(self, inputs: Sequence[str], outputs: Sequence[str], start: StartValues, every: int = 1) -> None:
        """Reset the FMU for another run."""
        self._ask("reset", tuple(inputs), tuple(outputs), dict(start), every)
        self._prepare(inputs, outputs, every)

    def enter(self, start_time: float) -> None:
        """Begin initialisation at `start_time` (s)."""
        self._ask("enter", start_time, self.stop_time)

    def leave(self) -> None:
        """End initialisation."""
        self._ask("leave")

    def write(self) -> None:
        """Send `inputs` to the FMU."""
        self._ask("write", self.inputs)

    def transform(self, laws: Sequence[tuple[float, float]]) -> None:
        """Send factor times value plus offset for each of `inputs`, until the next reset."""
        self._ask("transform", list(laws))

    def read(self) -> None:
        """Fetch `outputs` from the FMU."""
        self.outputs[:] = self._ask("read")

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        self._ask("step", time, step_size)

    def save(self) -> None:
        """Store the state of the FMU, replacing the previously stored one."""
        self._ask("save")

    def restore(self) -> None:
        """Restore the stored state."""
        self._ask("restore")

    def hold(self) -> HeldState:
        """Return the state of the FMU, which survives a reset and is freed by `close`."""
        state = HeldState(c_void_p())
        self._numbers_of_states[state] = self._ask("hold")
        return state

    def forget(self, state: HeldState) -> None:
        """Free a held state unless it is already free."""
        number = self._numbers_of_states.pop(state, None)
        if number is not None:
            self._ask("forget", number)

    def serialise(self) -> bytes:
        """Return the state of the FMU as bytes."""
        state: bytes = self._ask("serialise")
        return state

    def put(self, state: FmuState, warnings: Sequence[str] = ()) -> None:
        """Restore a held or serialised state; `warnings` are the warnings logged up to it."""
        stored = self._numbers_of_states[state] if isinstance(state, HeldState) else state
        self._ask("put", stored, list(warnings))

    @property
    def warnings(self) -> list[str]:
        """Warnings logged by the FMU since the end of its initialisation; none after its process has ended."""
        with suppress(ProcessFailed):
            said: list[str] = self._ask("warnings")
            return said
        return []

    def close(self) -> None:
        """Terminate and free the instance and end its process; it never raises."""
        with suppress(Exception):
            if self._process.returncode is None:
                self._ask("close")
        self._stack.close()

    def _ask(self, method: str, *arguments: Any) -> Any:
        stream = self._process.stdin
        assert stream is not None
        with suppress(OSError, ValueError):  # the process has ended, which the missing answer shows
            pickle.dump((method, arguments), stream)
            stream.flush()
        return self._answer()

    def _answer(self) -> Any:
        stream = self._process.stdout
        assert stream is not None
        try:
            error, result = pickle.load(stream)
        except Exception as broken:  # it has ended, or the FMU wrote among the answers
            raise ProcessFailed(f"the process of {self.name} {self._end()}") from broken
        if error is not None:
            raise error
        return result

    def _end(self) -> str:
        """Return how the process ended."""
        try:
            return how_it_ended(self._process.wait(END_TIME))
        except subprocess.TimeoutExpired:
            end_group(self._process)
            return "gave no answer, and was ended"
