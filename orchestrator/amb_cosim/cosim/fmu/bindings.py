"""Calls of an FMU instance that do not depend on the version of FMI; `binding2` and `binding3` contain the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from ctypes import c_void_p, cast
from typing import Any

from fmpy.fmi1 import FMICallException

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
WARNING, DISCARD, ERROR, FATAL = (STATUS.index(name) for name in ("Warning", "Discard", "Error", "Fatal"))
INFORMATION = (STATUS.index("OK"), STATUS.index("Pending"))
# noSetFMUStatePriorToCurrentPoint of all steps, also in `loop.c`. A repeated step begins at the current point, which is
# not prior to it. A held or serialised state is restored by another run, after a reset or in a new instance.
NO_EARLIER_STATE = True
MOST_WARNINGS, MOST_INFORMATION = 100, 10  # stored per instance; of faults, as many as both


class Log:
    """Log messages of an instance, with their status.

    The log keeps the first `MOST_WARNINGS` warnings and the last `MOST_INFORMATION` messages for information. Of the
    faults, it keeps the first `MOST_WARNINGS` and the last `MOST_INFORMATION`. `in_words` replaces references in a text
    by names.
    """

    def __init__(self) -> None:
        self.messages: list[tuple[int, str]] = []
        self.in_words: Callable[[str], str] = str

    def add(self, status: int, text: str) -> None:
        text = self.in_words(text)
        if status == WARNING and len(self.warnings) == MOST_WARNINGS:
            return
        first = 0 if status in INFORMATION else MOST_WARNINGS
        kept = [message for message in self.messages if _kind(message[0]) == _kind(status)]
        if len(kept) == first + MOST_INFORMATION:
            self.messages.remove(kept[first])
        self.messages.append((status, text))

    def forget(self, messages: Sequence[tuple[int, str]]) -> None:
        """Remove exactly these message objects, not other messages that are equal to them."""
        forgotten = set(map(id, messages))
        self.messages[:] = [message for message in self.messages if id(message) not in forgotten]

    @property
    def warnings(self) -> list[str]:
        return [text for status, text in self.messages if status == WARNING]

    @property
    def complaints(self) -> list[str]:
        """Warnings, and faults of calls that succeeded."""
        return [text for status, text in self.messages if status not in INFORMATION]

    def explanations(self) -> list[str]:
        """Return the texts that explain a refusal: faults, or else information, or else warnings."""
        faults = [text for status, text in self.messages if status not in (*INFORMATION, WARNING)]
        return faults or [text for status, text in self.messages if status in INFORMATION] or self.warnings


def _kind(status: int) -> str:
    return "information" if status in INFORMATION else "warning" if status == WARNING else "fault"


class Binding:
    """Part of an FMU instance that is the same in all versions of FMI; functions are named as in 3.0, without `fmi3`.

    Attributes
    ----------
    fmu
        The instance of fmpy.
    log
        Its messages.
    """

    fmu: Any
    log: Log

    @staticmethod
    def function(name: str) -> str:
        """Return the name of a function in this version of FMI."""
        raise NotImplementedError

    def prepare(self) -> None:
        """Direct messages to this project's logger again."""

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function of the library for the instance, with the argument types that FMPy has declared.

        Raises
        ------
        FMICallException
            If the function returns neither OK nor Warning.
        """
        function = self.function(name)
        check_status(function, getattr(self.fmu.dll, function)(self.fmu.component, *arguments))

    def free(self) -> None:
        """Free the instance and its library."""
        self.abandon()
        self.fmu.freeInstance()

    def abandon(self) -> None:
        """Forget the instance without calling the FMU, for example after the status Fatal."""


def check_status(function: str, status: int | None) -> None:
    """Raise an error for a status other than OK and Warning; FMPy may return no status, or accept a negative one."""
    if status is not None and not 0 <= status <= WARNING:
        raise FMICallException(function=function, status=status)


def reached_text(time: float) -> str:
    """Return a phrase that states the time (s) that an FMU reached in a discarded step."""
    return f"its lastSuccessfulTime is {time:.9g} s"


def address(fmu: Any, function: str) -> int:
    """Return the address of a function of an FMU's library."""
    return cast(getattr(fmu.dll, function), c_void_p).value or 0
