"""Saves the state of a run while it runs: at requested points, and periodically in case it is killed."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from amb_cosim.cosim.master.master import Observer
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.plan_session import Simulator
from amb_cosim.cosim.run.state_fingerprint import state_fingerprint
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.tables import moment_of
from amb_cosim.cosim.system.values import Raw

log = logging.getLogger(__name__)

AUTOSAVE_TIME = 60.0  # s between two automatic checkpoints
SHARE = 0.05  # at most, of the time of a run, that automatic checkpoints take
FIRST = 16  # steps until it is known how long they take

Take = Callable[[int, Checkpoint], None]


@dataclass(frozen=True)
class Saves:
    """States to save during a run.

    Attributes
    ----------
    points
        Communication points; a state is that of the last point, not after them, at which all components have completed
        their steps.
    file, every
        File of automatic checkpoints, each replacing the previous one, and wall-clock time between them (s).
    held
        Whether the states at `points` stay in the memory of the FMUs.
    """

    points: tuple[int, ...] = ()
    file: Path | None = None
    every: float = AUTOSAVE_TIME
    held: bool = False

    def possible(self, assembly: Assembly) -> Saves:
        """Return the same without automatic checkpoints if an FMU cannot serialise its state.

        Raises
        ------
        ValueError
            If an FMU lacks the capabilities that the points require.
        """
        interfaces = assembly.interfaces.items()
        unable = [name for name, interface in interfaces if not interface.serialises_state]
        lacking = [name for name, interface in interfaces if not interface.saves_state] if self.held else unable
        if lacking and self.points:
            flag = "canGetAndSetFMUstate" if self.held else "canSerializeFMUstate"
            raise ValueError(f"no checkpoint can be made of {', '.join(lacking)}: an FMU must have {flag}")
        return replace(self, file=None) if unable else self


def run_saving(simulator: Simulator, begin: int, saves: Saves, observers: Sequence[Observer], take: Take) -> None:
    """Run a plan from point `begin` to its end and save its state; `take` is called with each point and its state.

    Raises
    ------
    StepFailed, Stopped
        As `Simulator.advance`.
    """
    grid, last = simulator.grid, simulator.plan.last
    due = sorted((n - n % grid, n) for n in saves.points if n - n % grid >= begin)
    size, next_save = FIRST * grid, time.monotonic() + saves.every
    while begin <= last:
        while due and due[0][0] == begin:
            take(due.pop(0)[1], simulator.checkpoint(begin, saves.held))
        stop = min([last + 1, *(n for n, _ in due[:1]), *([begin + size] if saves.file else [])])
        started = time.monotonic()
        simulator.advance(begin, stop, observers)
        begin, now = stop, time.monotonic()
        if saves.file is None:
            continue
        size = 4 * size if now - started < saves.every / 8.0 else max(grid, size // 2 // grid * grid)
        if now >= next_save and begin <= last:
            _save(simulator.checkpoint(begin), saves.file)
            next_save = time.monotonic() + max(saves.every, (time.monotonic() - now) / SHARE)


def _save(checkpoint: Checkpoint, file: Path) -> None:
    """Write an automatic checkpoint; the run continues if that fails."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        checkpoint.save(file)
    except OSError as error:
        log.warning("the run continues without an automatic checkpoint: %s", error)


def resumed(file: Path | None, assembly: Assembly, plan: Plan) -> Checkpoint | None:
    """Return the automatic checkpoint in a file, if the run of a plan can continue from it."""
    if file is None or not file.is_file():
        return None
    try:
        result = Checkpoint.load(file)
        result.check_past(state_fingerprint(assembly, plan, result.point))
        if result.point > plan.last:
            raise ValueError(f"the run ends before t = {result.time:.9g} s")
    except ValueError as error:
        log.warning(
            "the run starts from the beginning, because the checkpoint in %s is of another run: %s", file, error
        )
        return None
    log.warning("the run continues from %s, at t = %.9g s", file, result.time)
    return result


def save_points(moments: Sequence[Raw], plan: Plan) -> tuple[int, ...]:
    """Return the communication points of times such as `cycle 5` or `0.3 s`.

    Raises
    ------
    ValueError
        If one is not a time, or after the end of the plan.
    """
    points: list[int] = []
    for moment in moments:
        points.append(plan.grid.nearest("a moment", moment_of(moment, plan.period or None)))
        if points[-1] > plan.last:
            raise ValueError(f"no state can be saved at {moment}; the run ends at {plan.time(plan.last):.9g} s")
    return tuple(points)
