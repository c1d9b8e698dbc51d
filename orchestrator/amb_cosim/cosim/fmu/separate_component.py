"""An FMU instance in a process of its own, for FMUs that cannot share a process with others (`process_sharing`).

Each call is a request to that process, `component_process`, which answers with a result or an error. The compiled loop
cannot call it.
"""

from __future__ import annotations

import pickle
import subprocess
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.fmu.component import FmuComponent, StartValues
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.processes.child_process import child_process, end_group, how_it_ended

END_TIME = 10.0  # s in which a process that no longer answers has to end


def _forwarded(method: str) -> Callable[..., Any]:
    """Return a method that calls the same method of the `FmuComponent` in the process."""
    return lambda self, *arguments: self._ask(method, *arguments)


class SeparateComponent(FmuComponent):
    """An `FmuComponent` in a separate process; the arguments and errors are the same, with `ProcessFailed` added."""

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
        self._ask("reset", tuple(inputs), tuple(outputs), dict(start), every)
        self._prepare(inputs, outputs, every)

    def enter(self, start_time: float) -> None:
        self._ask("enter", start_time, self.stop_time)

    def write(self) -> None:
        self._ask("write", self.inputs)

    def read(self) -> None:
        self.outputs[:] = self._ask("read")

    leave, transform, step, save, restore, hold, forget, serialise, put = map(
        _forwarded, ("leave", "transform", "step", "save", "restore", "hold", "forget", "serialise", "put")
    )

    @property
    def warnings(self) -> list[str]:
        """Warnings logged by the FMU since the end of its initialisation; none after its process has ended."""
        with suppress(ProcessFailed):
            warnings: list[str] = self._ask("warnings")
            return warnings
        return []

    def close(self) -> None:
        """Terminate and free the instance, and end its process; raise no error."""
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
            return "did not answer, and was ended"
