"""`simulate`: from a system file, or a system and an experiment, to a labelled data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from amb_cosim.cosim.basics.choices import Flavour, Loop
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.dataset import Run, to_signals
from amb_cosim.cosim.run.run_plan import Progress, run_plan
from amb_cosim.cosim.run.saving import Saves, save_points
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.planning import plan_experiment
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import load_experiment, load_system
from amb_cosim.cosim.system.values import Raw


class Simulation(Run):
    """A run of a system: every recorded variable over time (s), and how the run ended."""

    def save(self, folder: str | Path) -> Path:
        """Write `result.nc` into a folder, made if it is missing, and return the folder."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        self._save(folder / "result.nc")
        return folder


def simulate(
    system: str | Path | System,
    experiment: Experiment | None = None,
    *,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
    loop: Loop = "compiled",
    progress: Progress | None = None,
    step_size: float | None = None,
    stop_time: float | None = None,
    isolated: bool | None = None,
    save_at: Sequence[Raw] = (),
    start: Checkpoint | str | Path | None = None,
    **options: Any,
) -> Simulation:
    """Run a system of co-simulation FMUs, of FMI 2.0 and 3.0.

    Parameters
    ----------
    system
        A `System`, or the path of a system file or of an SSP archive.
    experiment
        What is done with it; by default what the table `experiment` of the file says, or the archive.
    set
        Values by `component.variable`, or by a signal's name, in place of the file's.
    flavour
        Which flavour of this project's models is built; FMU files are taken as they are.
    loop
        `compiled`, or `plain` Python for reference; the results are the same to the last bit.
    progress
        Called now and then with the steps done and their number.
    step_size, stop_time
        Of an SSP archive, in s, in place of what it says itself.
    isolated
        Whether the FMUs run in a process of their own, so that their crash is an exception here; by default they do if
        one of them was given as a file.
    save_at
        Times, such as `0.3 s`, whose state `checkpoint` gives: what happens then has not happened yet.
    start
        A checkpoint, or its file, from which the run goes on; it must have the same past.
    options
        What models are made for, such as `rotor`, the name of a rotor of a pack or a rotor file.

    Raises
    ------
    ValueError
        If the file, a connection or a value is wrong.
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    ProcessFailed
        If the FMUs' own process crashed or had to be ended.
    """
    inputs: Mapping[str, Raw] = {}
    if not isinstance(system, System) and Path(system).suffix == ".ssp":
        from amb_cosim.cosim.ssp import load_ssp  # loads XML libraries

        system, local, inputs = load_ssp(system, step_size, stop_time)
        experiment = experiment or local
    elif not isinstance(system, System):
        if step_size is not None or stop_time is not None:
            raise ValueError("step_size and stop_time are for SSP archives; a system file has them in its experiment")
        if experiment is None:
            experiment, inputs = load_experiment(system)
        system = load_system(system)
    if experiment is None:
        raise ValueError(f"system {system.name} needs an experiment, which says how long it runs")
    assembly = assemble(system, flavour, **options)
    values = assembly.assignments()
    for name, raw in inputs.items():
        values.set_first(name, raw)
    for name, raw in (set or {}).items():
        values.set(name, raw)
    plan = plan_experiment(experiment, values)
    saves = Saves(save_points(save_at, plan))
    start = Checkpoint.load(start) if isinstance(start, str | Path) else start
    recording = run_plan(assembly, plan, progress, loop, isolated=isolated, start=start, saves=saves)
    return Simulation(to_signals(recording), recording.outcome, recording.checkpoints)
