"""Options of a run, in one record that can be passed to a separate process; no option changes a result."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from amb_cosim.cosim.choices import FLAVOURS, LOOPS, Flavour, Loop
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.state_fingerprint import state_fingerprint
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.tables import moment_of
from amb_cosim.cosim.system.values import Raw, plain_value
from amb_files.checks import as_items, require_choice

log = logging.getLogger(__name__)

AUTOSAVE_TIME = 60.0  # s between two automatic checkpoints

Progress = Callable[[int, int], None]  # steps done, and their number


@dataclass(frozen=True)
class Saves:
    """States to save during a run.

    Attributes
    ----------
    points
        Communication points. A state is saved at the requested point. If some components have not completed their steps
        there, it is saved at the last earlier point at which all components have.
    file, every
        File of automatic checkpoints, each of which replaces the previous one, and the wall-clock time between them
        (s).
    held
        Whether the states at `points` stay in the memory of the FMUs.
    moments
        Times such as `cycle 5` or `0.3 s`, whose points `for_plan` adds.
    """

    points: tuple[int, ...] = ()
    file: Path | None = None
    every: float = AUTOSAVE_TIME
    held: bool = False
    moments: Raw | Sequence[Raw] = ()

    def __post_init__(self) -> None:
        moments = tuple(plain_value(moment, "save_at") for moment in as_items(self.moments))
        object.__setattr__(self, "moments", moments)

    def for_plan(self, plan: Plan) -> Saves:
        """Return these saves with the points of all moments; drop automatic saves if an FMU cannot serialise its state.

        Raises
        ------
        ValueError
            If a moment is not a time or is after the end of the plan, or if an FMU cannot save or serialise its state.
        """
        points = [*self.points]
        for moment in as_items(self.moments):
            points.append(plan.grid.nearest("moment", moment_of(moment, plan.period or None, "save_at")))
            if points[-1] > plan.last:
                raise ValueError(
                    f"no state can be saved at {moment}, because the run ends at {plan.time(plan.last):.9g} s"
                )
        interfaces = plan.interfaces.items()
        unable = [name for name, interface in interfaces if not interface.serialises_state]
        lacking = [name for name, interface in interfaces if not interface.saves_state] if self.held else unable
        if lacking and points:
            flag = "canGetAndSetFMUstate" if self.held else "canSerializeFMUstate"
            raise ValueError(
                f"no checkpoint of {', '.join(lacking)} is possible: a checkpoint requires FMUs with {flag}"
            )
        return replace(self, moments=(), points=tuple(points), file=None if unable else self.file)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run.

    flavour
        Flavour of this project's models, which applies when the FMUs of the run are found; FMU files are used
        unchanged.
    loop
        Loop for explicit coupling; iterative coupling uses the plain loop. The loop `plain` calls the FMUs from Python;
        it gives the same results as `compiled` to the last bit. Without a compiled loop (see `loop_library`), the plain
        one runs.
    isolated
        Whether the FMUs run in a separate process; by default only if one of them is an FMU file.
    instances
        Loaded FMUs, kept for the next run of the same assembly.
    start
        State of a run with the same past, from which the run continues; the record covers the whole run.
    saves
        States to save during the run.
    progress
        Function that is called repeatedly with the number of finished steps and the number of all steps.

    Raises
    ------
    ValueError
        If there is no such flavour or loop.
    """

    flavour: Flavour = "native"
    loop: Loop = "compiled"
    isolated: bool | None = None
    instances: InstancePool | None = None
    start: Checkpoint | None = None
    saves: Saves = field(default_factory=Saves)
    progress: Progress | None = None

    def __post_init__(self) -> None:
        require_choice("flavour", self.flavour, FLAVOURS)
        require_choice("loop", self.loop, LOOPS)

    @property
    def has_end(self) -> bool:
        """Whether the run is independent: it does not continue another run, and no other run continues from it."""
        return self.start is None and not self.saves.points and self.saves.file is None

    def for_plan(self, plan: Plan) -> RunOptions:
        """Return the options with `isolated`, `saves` and, if the plan resumes a run, `start` set for the plan."""
        saves = self.saves.for_plan(plan)
        isolated = bool(plan.assembly.from_elsewhere) if self.isolated is None else self.isolated
        return replace(self, isolated=isolated, saves=saves, start=_resumed(self.saves.file, plan) or self.start)


DEFAULTS = RunOptions()


def _resumed(file: Path | None, plan: Plan) -> Checkpoint | None:
    """Return the automatic checkpoint in a file, if the run of a plan can continue from it."""
    if file is None or not file.is_file():
        return None
    try:
        checkpoint = Checkpoint.load(file)
        checkpoint.check_past(state_fingerprint(plan, checkpoint.point), plan.assembly.sources)
        if checkpoint.point > plan.last:
            raise ValueError(f"the run ends before {checkpoint.title}, which is at t = {checkpoint.time:.9g} s")
    except ValueError as error:
        log.warning("the run starts from the beginning: %s", error)
        return None
    log.warning("the run continues from %s, at t = %.9g s", file, checkpoint.time)
    return checkpoint
