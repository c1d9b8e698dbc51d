"""What an FMU instance is asked to do, in the words of either version of FMI; `binding2`, `binding3` are the two."""

from __future__ import annotations

from ctypes import c_void_p, cast
from typing import Any

from fmpy.fmi1 import FMICallException

from amb_cosim.cosim.fmu.exchange import Exchanging

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
WARNING, DISCARD, ERROR = (STATUS.index(name) for name in ("Warning", "Discard", "Error"))
MOST_WARNINGS = 100  # of an instance that are kept


class Log:
    """Messages of an instance, with their status; of warnings the first `MOST_WARNINGS`."""

    def __init__(self) -> None:
        self.messages: list[tuple[int, str]] = []

    def add(self, status: int, text: str) -> None:
        if status != WARNING or len(self.warnings) < MOST_WARNINGS:
            self.messages.append((status, text))

    @property
    def warnings(self) -> list[str]:
        return [text for status, text in self.messages if status == WARNING]

    def said(self) -> list[str]:
        """Return what was logged, without warnings if there is more than those."""
        return [text for status, text in self.messages if status != WARNING] or self.warnings


class Binding(Exchanging):
    """An FMU instance; its functions have the names of FMI 3.0 without `fmi3`.

    Attributes
    ----------
    fmu
        That of fmpy.
    log
        What it has said.
    instance, do_step
        Addresses of what a step is called with, and of its function, whose arguments are those of fmi2DoStep.
    """

    fmu: Any
    log: Log

    @staticmethod
    def function(name: str) -> str:
        """Return what this version of FMI calls a function."""
        raise NotImplementedError

    @property
    def instance(self) -> int:
        raise NotImplementedError

    @property
    def do_step(self) -> int:
        raise NotImplementedError

    def prepare(self) -> None:
        """Have messages come to this project's logger again."""

    def enter(self, start_time: float) -> None:
        """Begin initialisation at `start_time` (s)."""
        raise NotImplementedError

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` (s)."""
        raise NotImplementedError

    def reasons(self, call: str, status: int) -> list[str]:
        """Return what is known, besides what the FMU has logged, of why a call was answered with a status."""
        raise NotImplementedError

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function for the instance.

        Raises
        ------
        FMICallException
            If it answers with neither OK nor Warning.
        """
        function = self.function(name)
        check_status(function, getattr(self.fmu, function)(self.fmu.component, *arguments))

    def free(self) -> None:
        """Free the instance and its library."""
        self.fmu.freeInstance()


def check_status(function: str, status: int | None) -> None:
    """Raise for a status below OK as FMPy does for one above Warning; most of its methods return the status."""
    if status is not None and status < 0:
        raise FMICallException(function=function, status=status)


def reached_text(time: float) -> str:
    """Return a phrase on the time (s) that an FMU came to in a step that it discarded."""
    return f"its lastSuccessfulTime is {time:.9g} s"


def address(fmu: Any, function: str) -> int:
    """Return the address of a function of an FMU's library."""
    return cast(getattr(fmu.dll, function), c_void_p).value or 0
