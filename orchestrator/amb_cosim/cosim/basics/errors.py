"""Errors of a run: an FMU refuses a call, or a start or a step fails."""

from __future__ import annotations

from collections.abc import Sequence


class FmuError(RuntimeError):
    """An FMU refused a call; `status` is its FMI status, `log` its messages."""

    def __init__(self, call: str, status: str, log: Sequence[str]) -> None:
        said = "; ".join(dict.fromkeys(log)) if log else "the FMU logged nothing"
        super().__init__(f"{call} answered {status}: {said}")
        self.call = call
        self.status = status
        self.log = list(log)

    def __reduce__(self) -> tuple[type[FmuError], tuple[str, str, list[str]]]:
        return FmuError, (self.call, self.status, self.log)


class StepFailed(RuntimeError):
    """A component did not complete a step; `component` and `time` (s) identify it."""

    def __init__(self, component: str, time: float, reason: str) -> None:
        super().__init__(f"{component} failed at t = {time:.9g} s: {reason}")
        self.component = component
        self.time = time
        self.reason = reason


class StartFailed(RuntimeError):
    """The components cannot be initialised: one refuses, or their outputs do not settle."""


class ProcessFailed(RuntimeError):
    """The process that ran FMUs ended, or had to be ended, before it answered."""
