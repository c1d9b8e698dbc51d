"""Options of a run in one record, from the call to the separate process; none changes a result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from amb_cosim.cosim.basics.choices import Loop
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.saving import Saves

Progress = Callable[[int, int], None]  # steps done, and their number


@dataclass(frozen=True)
class RunOptions:
    """Options of the run of a plan.

    loop
        Loop of an explicit coupling; iterative coupling uses the plain loop. `compiled` and `plain`, which calls the
        FMUs from Python, give the same results to the last bit. Without a compiled loop (see `loop_library`), the plain
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
        Called repeatedly with the number of finished steps and of all steps.
    """

    loop: Loop = "compiled"
    isolated: bool | None = None
    instances: InstancePool | None = None
    start: Checkpoint | None = None
    saves: Saves = field(default_factory=Saves)
    progress: Progress | None = None


DEFAULTS = RunOptions()
