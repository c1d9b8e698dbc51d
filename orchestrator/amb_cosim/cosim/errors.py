"""Errors and warnings of a run: an FMU refuses a call, a start or a step fails, or the user interrupts it."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

T = TypeVar("T")

OURS = re.compile(r"(amb_\w+|contextlib|functools)(\.|$)")  # modules between a user's line and a warning


class ModelWarning(UserWarning):
    """A result is doubtful, because a model of the run was used beyond its limits or a setting is implausible.

    The sentences are also in the result, as `summary.warnings` of a run or `warnings` of a study.

    Examples
    --------
    >>> import warnings
    >>> import amb_cosim
    >>> warnings.simplefilter("error", amb_cosim.ModelWarning)  # end a script at the first one
    >>> warnings.simplefilter("ignore", amb_cosim.ModelWarning)  # print none
    """


def give_warnings(sentences: Iterable[str]) -> None:
    """Give each sentence as a `ModelWarning`, at the line of the user's code that called this package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and OURS.match(str(frame.f_globals.get("__name__"))):
        frame, level = frame.f_back, level + 1
    for sentence in dict.fromkeys(sentences):
        warnings.warn(sentence, ModelWarning, stacklevel=level)


class FmuError(RuntimeError):
    """An FMU refused a call; `status` is its FMI status, and `log` contains its messages.

    If the FMU ended the run in a step, as FMI allows, `end` is the time (s) that it reached in this step, or NaN if it
    stated no time. In all other cases, `end` is None.
    """

    def __init__(self, call: str, status: str, log: Sequence[str], end: float | None = None) -> None:
        self.log_text = "; ".join(dict.fromkeys(log)) if log else "the FMU logged nothing"
        super().__init__(f"{call} answered {status}: {self.log_text}")
        self.call = call
        self.status = status
        self.log = list(log)
        self.end = end

    def __reduce__(self) -> tuple[type[FmuError], tuple[str, str, list[str], float | None]]:
        return FmuError, (self.call, self.status, self.log, self.end)


class StepFailed(RuntimeError):
    """A component did not complete a step; `component` and `time` (s) identify the step.

    `end` is copied from the `FmuError` if the component ends the run in this step.
    """

    def __init__(self, component: str, time: float, reason: str, end: float | None = None) -> None:
        super().__init__(f"{component} failed at t = {time:.9g} s: {reason}")
        self.component = component
        self.time = time
        self.reason = reason
        self.end = end

    @classmethod
    def by(cls, component: str, time: float, error: Exception, cause: str = "") -> StepFailed:
        """Return the error for a component whose step from `time` (s) raised `error`; its reason ends with `cause`."""
        if isinstance(error, FmuError) and error.end is not None:
            return cls(component, time, f"{component} ended the run ({error.log_text})", error.end)
        return cls(component, time, f"{error}{cause}")


class StartFailed(RuntimeError):
    """The components cannot be initialised, because one of them refuses or their outputs do not settle."""


class ProcessFailed(RuntimeError):
    """The process that ran FMUs ended, or had to be ended, before it answered."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a function early; `result` is what it computed until then, of the type that it returns.

    A loop over runs ends too, unless it catches this error.
    """

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message, result)
        self.result = result

    def __str__(self) -> str:
        return f"{self.args[0]}; the attribute `result` of this error has what was computed"


def computed_by(function: Callable[..., T], *arguments: Any, **options: Any) -> T:
    """Return the result of a function that Ctrl-C may end early: what it computed until then."""
    try:
        return function(*arguments, **options)
    except Interrupted as error:
        result: T = error.result
        return result
