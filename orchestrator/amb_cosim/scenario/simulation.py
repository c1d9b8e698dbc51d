"""Runs scenarios: prepares the run, executes its plan, and builds the result from its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path

from amb_cosim.cosim.choices import Flavour, Loop
from amb_cosim.cosim.errors import give_warnings
from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.run.checkpoint import Checkpoint, as_checkpoint
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.options import AUTOSAVE_TIME, DEFAULTS, Progress, RunOptions, Saves
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.results.result import Result
from amb_cosim.results.summary import run_warnings
from amb_cosim.scenario.make_result import make_result
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.rotors import RotorSource, TableSource
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.checks import require_given


def run(
    scenario: str | Path | Scenario,
    *,
    set: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    rotor: RotorSource = None,
    receptances: TableSource = None,
    fmu: Mapping[str, FmuSource | PathLike[str]] | None = None,
    flavour: Flavour = "native",
    loop: Loop = "compiled",
    progress: bool | Progress | None = None,
    isolated: bool | None = None,
    save_at: Raw | Sequence[Raw] = (),
    start: Checkpoint | str | Path | None = None,
    autosave: str | Path | None = None,
    autosave_every: Raw = AUTOSAVE_TIME,
) -> Result:
    """Run a scenario and return its result.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of a packaged scenario, or the path of a TOML file.
    set
        Values by `component.variable` that replace the scenario's: `{"rotor_contact.seal.clearance": "0.6 mm"}`. A
        number is in the unit of the variable.
    until
        End of the run, measured from the beginning of cycle 0, in s or as a text with a unit.
    rotor, receptances
        Replacements of the scenario's rotor and of its table of receptances for the controller's H. The rotor is a
        `Rotor`, the name of a packaged rotor, or a rotor file; the table is a `ReceptanceTable` or its file.
    fmu
        Replacements of components, by the name of the component: an FMU, a model, or a controller from
        `amb_cosim.linear_controller`.
    flavour
        `native` for FMUs that are compiled and need no Python, or the flavour of FMUs that PythonFMU runs.
    loop
        `compiled`, or `plain` Python for reference; the results are the same to the last bit.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function that is called with the number of
        finished steps and the number of all steps.
    isolated
        Whether the FMUs run in a separate process, so that a crash only raises an exception; by default only if one of
        them is an FMU file.
    save_at
        Time or times, such as `cycle 5` or `0.3 s`, whose state `result.checkpoint` returns. The state does not yet
        include changes at these times.
    start
        A checkpoint with the same past, or its file, from which the run continues. The result equals that of the whole
        run to the last bit.
    autosave, autosave_every
        File for automatic checkpoints, and computing time between them (in s or as a text with a unit). If the same run
        is started again, it continues from this file.

    Warns
    -----
    ModelWarning
        For each sentence of `result.summary.warnings`; commands print these sentences instead.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid; the message names the place and the allowed values.
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start. A failure during the run raises no exception: `result.outcome`
        states component, time and reason.
    ProcessFailed
        If the FMUs' own process crashed or had to be ended.
    Interrupted
        If Ctrl-C ends the run. This is a KeyboardInterrupt; its attribute `result` has what was computed until then.
    """
    require_given("scenario", scenario)
    every = quantity(autosave_every, "s", "autosave_every")
    saves = Saves(file=None if autosave is None else Path(autosave), every=every, moments=save_at)
    start = as_checkpoint(start)
    with progress_bar(progress) as report:
        options = RunOptions(flavour=flavour, loop=loop, isolated=isolated, start=start, saves=saves, progress=report)
        prepared = prepare_run(as_scenario(scenario, rotor, receptances, fmu), set, until, options)
        recording = execute_plan(prepared, options)
    result = make_result(prepared, recording).unless_interrupted()
    give_warnings(run_warnings(result.signals))
    return result


def execute(plan: ScenarioPlan, options: RunOptions = DEFAULTS) -> Result:
    """Execute a prepared run and return its result; see `execute_plan` for the errors."""
    return make_result(plan, execute_plan(plan, options))


def check(scenario: str | Path | Scenario) -> None:
    """Raise ValueError if a scenario does not fit the components that it runs; their FMUs are built if necessary.

    The scenario is a `Scenario`, the name of a packaged scenario, or the path of a TOML file.

    Examples
    --------
    >>> check("compressor_levitated")  # raises nothing: it can run
    """
    require_given("scenario", scenario)
    prepare_run(as_scenario(scenario))
