"""`simulate` runs a system file, or a system and an experiment, and returns a labelled data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from amb_cosim.cosim.choices import Flavour, Loop
from amb_cosim.cosim.errors import give_warnings
from amb_cosim.cosim.fmu.fmus import options_of
from amb_cosim.cosim.record.warnings import sentences, warnings_of
from amb_cosim.cosim.run.checkpoint import Checkpoint, as_checkpoint
from amb_cosim.cosim.run.dataset import Run, to_signals
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.options import Progress, RunOptions, Saves
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import load_experiment, load_system
from amb_cosim.cosim.system.tables import time_of
from amb_cosim.cosim.system.values import Raw
from amb_files.atomic import plain_file
from amb_files.checks import as_path
from amb_files.suggestions import suggest


class Simulation(Run):
    """A run of a system: every recorded variable over time (s), and the outcome."""

    def save(self, folder: str | Path) -> Path:
        """Write `result.nc` into a folder, which is created if it is missing, and return the folder."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        self._save(plain_file(folder, "result.nc"))
        return folder


def simulate(
    system: str | Path | System,
    experiment: Experiment | None = None,
    *,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
    loop: Loop = "compiled",
    progress: bool | Progress | None = None,
    step_size: Raw | None = None,
    stop_time: Raw | None = None,
    isolated: bool | None = None,
    save_at: Raw | Sequence[Raw] = (),
    start: Checkpoint | str | Path | None = None,
    **options: Any,
) -> Simulation:
    """Run a system of FMI 2.0 and 3.0 FMUs for co-simulation.

    Parameters
    ----------
    system
        A `System`, or the path of a system file or of an SSP archive.
    experiment
        The experiment; by default, the experiment in the file's table `experiment`, or in the archive.
    set
        Values by `component.variable`, or by a signal's name, which replace values in the file.
    flavour, loop, isolated, save_at, start
        As for `amb_cosim.run`; FMU files have no flavour, and times cannot be stated in cycles.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function that is called with the number of
        finished steps and the number of all steps.
    step_size, stop_time
        Communication step and end of the run, in s or as a text with a unit. They replace the values in an SSP archive.
    options
        Options of models, such as `rotor`, the name of a packaged rotor or a rotor file.

    Raises
    ------
    ValueError
        If the file, a connection or a value is wrong, or an option belongs to no model.
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start.
    ProcessFailed
        If the separate process of the FMUs crashed or had to be ended.
    Interrupted
        If Ctrl-C ends the run. This is a KeyboardInterrupt; its attribute `result` has what was computed until then.

    Examples
    --------
    >>> from amb_cosim.cosim.system.experiment import Experiment
    >>> settings = {"Omega": "9000 rpm", "rotor_contact.impeller3.u": "1 g.m"}
    >>> result = simulate(load_system("passive"), Experiment(1e-4, 0.01), set=settings, rotor="compressor")
    >>> print(result.outcome)
    completed at t = 0.01 s
    """
    saves, start = Saves(moments=save_at), as_checkpoint(start)
    run_options = RunOptions(flavour=flavour, loop=loop, isolated=isolated, start=start, saves=saves)
    if not isinstance(system, System) and as_path("system", system).suffix == ".ssp":
        from amb_cosim.cosim.ssp import load_ssp  # loads XML libraries

        times = (step_size, "step_size"), (stop_time, "stop_time")
        system, saved = load_ssp(system, *(None if raw is None else time_of(raw, name) for raw, name in times))
        experiment = saved if experiment is None else replace(experiment, inputs={**saved.inputs, **experiment.inputs})
    elif not isinstance(system, System):
        if step_size is not None or stop_time is not None:
            raise ValueError(
                "step_size and stop_time are for SSP archives; a system file states them in its experiment"
            )
        if experiment is None:
            experiment = load_experiment(system)
        system = load_system(system)
    if experiment is None:
        raise ValueError(f"system {system.name} needs an experiment that defines the duration of the run")
    taken = {name for component in system.components for name in options_of(component.fmu)}
    for name, value in options.items():
        if value is not None and name not in taken:  # the command line passes those that are not given as None
            raise ValueError(f"{name} is not an option of any model in {system.name}; {suggest(name, sorted(taken))}")
    assembly = assemble(system, flavour, **options)
    from amb_cosim.presentation.progress import progress_bar  # loads rich

    with progress_bar(progress) as report:
        recording = execute_plan(experiment_plan(experiment, assembly, set), replace(run_options, progress=report))
    result = Simulation(to_signals(recording), recording.outcome, recording.checkpoints).unless_interrupted()
    give_warnings(sentences(warnings_of(result.signals)))
    return result
