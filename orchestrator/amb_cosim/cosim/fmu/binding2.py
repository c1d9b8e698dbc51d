"""FMI 2.0 FMUs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from ctypes import byref, c_char, c_char_p, c_double, c_int, c_uint
from functools import cache, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from fmpy import calloc, free
from fmpy.fmi1 import printLogMessage
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2LastSuccessfulTime,
    fmi2Terminated,
)
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from amb_cosim.cosim.fmu.bindings import DISCARD, NO_EARLIER_STATE, Binding, Log, address, check_status, reached_text
from amb_cosim.cosim.fmu.exchange import Group, Transfer
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, TextVariable
from array_types import Array

REFERENCE = re.compile(r"##|#([ribs])(\d+)#")
_logs: dict[str | int | None, Log] = {}  # of instances, by name and by the environment of their logger


class Binding2(Binding):
    """An instance of an FMI 2.0 FMU."""

    byte = c_char
    kinds: ClassVar[Mapping[str, Any]] = {"Real": c_double, "Integer": c_int, "Boolean": c_int}

    def __init__(self, interface: FmuInterface, folder: Path, name: str, log: Log) -> None:
        self._log_keys, self._tolerance = (name, id(log)), interface.tolerance
        self.log = log
        log.in_words = partial(_with_names, _names(interface))
        _logs.update(dict.fromkeys(self._log_keys, log))
        self._callbacks = fmi2CallbackFunctions(
            allocateMemory=_ALLOCATE, freeMemory=_FREE, componentEnvironment=id(log)
        )
        self.fmu = FMU2Slave(
            guid=interface.guid,
            unzipDirectory=str(folder),
            modelIdentifier=interface.identifier,
            instanceName=name,
        )
        self.prepare()
        try:
            self.fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception:
            self.abandon()
            raise

    @staticmethod
    @cache
    def function(name: str) -> str:
        return "fmi2" + name.replace("FMUState", "FMUstate").replace("Deserialize", "DeSerialize")

    @property
    def instance(self) -> int:
        """Address of the instance."""
        return int(self.fmu.component)

    @property
    def do_step(self) -> int:
        """Address of fmi2DoStep."""
        return address(self.fmu, "fmi2DoStep")

    def prepare(self) -> None:
        """Let the logger of fmpy call `_receive` again, because another user of fmpy may have redirected the logger."""
        self._callbacks.logger = _LOGGER
        addLoggerProxy(byref(self._callbacks))

    def enter(self, start_time: float, stop_time: float | None = None) -> None:
        """Begin initialisation at `start_time` (s); if `stop_time` (s) is set, the run ends there."""
        check_status("fmi2SetupExperiment", self.fmu.setupExperiment(self._tolerance, start_time, stop_time))
        self.call("EnterInitializationMode")

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        self.call("DoStep", time, step_size, NO_EARLIER_STATE)

    def reasons(self, call: str, status: int) -> list[str]:
        """Return a phrase that explains a discarded step: the FMU ended the run, or reached only a certain time."""
        if status != DISCARD or call != "fmi2DoStep":
            return []
        if self.end_of_run(call, status) is not None:
            return ["fmi2Terminated is true"]
        reached = self._reached()
        return [] if math.isnan(reached) else [reached_text(reached)]

    def end_of_run(self, call: str, status: int) -> float | None:
        """Return the time (s) that the FMU reached in the step in which it ended the run; NaN if it states no time."""
        if status == DISCARD and call == "fmi2DoStep":
            with suppress(Exception):  # an FMU need not support this query
                if self.fmu.getBooleanStatus(fmi2Terminated):
                    return self._reached()
        return None

    def _reached(self) -> float:
        with suppress(Exception):
            return float(self.fmu.getRealStatus(fmi2LastSuccessfulTime))
        return math.nan

    def send_text(self, variable: TextVariable, value: str | bytes) -> None:
        """Set a String variable; FMI 2.0 has no Binary variables."""
        content = value.encode() if isinstance(value, str) else value
        self.call("SetString", (c_uint * 1)(variable.reference), 1, (c_char_p * 1)(content))

    def kind_of(self, port: Port) -> str:
        return port.type

    def send(self, group: Group, values: Array) -> None:
        group.store(values)
        self.call(f"Set{group.name}", group.references, len(group.references), group.image)

    def fetch(self, group: Group) -> NDArray[Any]:
        self.call(f"Get{group.name}", group.references, len(group.references), group.image)
        return group.load()

    def transfer(self, call: str, group: Group) -> Transfer:
        """Return a call that sets or gets variables."""
        function = address(self.fmu, self.function(call + group.name))
        return Transfer(function, np.array(group.references, np.uint32), group.where, group.name == "Real")

    def abandon(self) -> None:
        """Forget the instance without calling the FMU."""
        for name in self._log_keys:
            _logs.pop(name, None)


def _names(interface: FmuInterface) -> dict[tuple[str, str], str]:
    """Map the letter of a type and the digits of a value reference to the name of the first variable with both."""
    letters = {"Real": "r", "Integer": "i", "Boolean": "b", "String": "s"}
    variables: list[Port | TextVariable] = [*interface.ports.values(), *interface.texts.values()]
    return {(letters.get(v.type, ""), str(v.reference)): v.name for v in reversed(variables)}


def _with_names(names: Mapping[tuple[str, str], str], text: str) -> str:
    """Replace references to variables by names: FMI 2.0 writes `#r1#` for the Real with reference 1, and ## for #."""
    return REFERENCE.sub(lambda found: names.get((found[1], found[2]), found[0]) if found[1] else "#", text)


def _receive(environment: Any, instance: bytes | None, status: int, category: bytes, message: bytes | None) -> None:
    """Append a log message to the log of its instance.

    fmpy has one logger per process. A PythonFMU FMU calls the logger of the instance created last, but names its own
    instance in the text. Other FMUs may name no instance, or a wrong one; the argument `environment` then identifies
    the instance.
    """
    text = (message or b"").decode("utf-8", "replace").strip()
    named, _, rest = text.partition(": ")
    name = (instance or b"").decode("utf-8", "replace")
    for key, message_text in ((named, rest), (name, text), (environment, text)):
        if key in _logs:
            _logs[key].add(status, message_text)
            return
    printLogMessage(environment, name.encode(), status, category, text.encode())


_LOGGER = fmi2CallbackLoggerTYPE(_receive)
_ALLOCATE = fmi2CallbackAllocateMemoryTYPE(calloc)
_FREE = fmi2CallbackFreeMemoryTYPE(free)
