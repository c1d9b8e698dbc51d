"""Result of a run: its outcome and its record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.system.experiment import Plan

Status = Literal["completed", "stopped", "failed", "interrupted"]


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    status
        `completed`; `stopped`, by one of the run's conditions or, as FMI allows, by a component; `failed`, in a
        component; or `interrupted`, by the user.
    time
        Time that was reached (s).
    component
        The component that failed or stopped the run.
    reason
        The condition that was met, or the message of the component; empty for a completed run.
    """

    status: Status
    time: float
    component: str | None = None
    reason: str = ""

    @property
    def failure(self) -> str | None:
        """A sentence on the cause of an early end that was not planned; None if there was no such end."""
        if self.status == "failed":
            return f"{self.component} failed at t = {self.time:.12g} s: {self.reason}"
        return f"interrupted at t = {self.time:.12g} s" if self.status == "interrupted" else None

    @property
    def stopped(self) -> str | None:
        """The condition that ended the run, and the time of this end; None if no condition ended it."""
        return f"{self.reason}, at t = {self.time:.12g} s" if self.status == "stopped" else None

    def __str__(self) -> str:
        return self.failure or (f"stopped: {self.stopped}" if self.stopped else f"completed at t = {self.time:.12g} s")


@dataclass(frozen=True)
class Recording:
    """Record of a run up to its end; `warnings` are the logged warnings of each component.

    `checkpoints` are the requested states that the run reached, by point.
    """

    plan: Plan
    recorder: Recorder
    outcome: Outcome
    warnings: Mapping[str, list[str]]
    checkpoints: Mapping[int, Checkpoint] = field(default_factory=dict)
