"""Options of a run in one record, from the public function to the separate process; none changes a result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from amb_cosim.cosim.basics.choices import Flavour, Loop
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.saving import Saves, resumed
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan

Progress = Callable[[int, int], None]  # steps done, and their number


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run.

    flavour
        Flavour of this project's models, when the FMUs of the run are found; FMU files are used unchanged.
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

    flavour: Flavour = "native"
    loop: Loop = "compiled"
    isolated: bool | None = None
    instances: InstancePool | None = None
    start: Checkpoint | None = None
    saves: Saves = field(default_factory=Saves)
    progress: Progress | None = None

    @property
    def has_end(self) -> bool:
        """Whether no other run can continue from a state of this one, nor this one from another's."""
        return self.start is None and not self.saves.points and self.saves.file is None

    def for_plan(self, assembly: Assembly, plan: Plan) -> RunOptions:
        """Return the options of a run of a plan: points to save at, a process, an automatic checkpoint if it has one.

        Raises
        ------
        ValueError
            If a state cannot be saved at a time, or by an FMU.
        """
        saves = self.saves.for_plan(assembly, plan)
        isolated = bool(assembly.from_elsewhere) if self.isolated is None else self.isolated
        return replace(
            self, isolated=isolated, saves=saves, start=resumed(self.saves.file, assembly, plan) or self.start
        )


DEFAULTS = RunOptions()
