"""`amb_cosim.run`: one scenario, from its name to its result."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from amb_cosim.cosim.fmus import Flavour
from amb_cosim.cosim.master import Loop
from amb_cosim.cosim.simulation import Progress
from amb_cosim.cosim.values import Raw
from amb_cosim.progress import progress_bar
from amb_cosim.result import Result
from amb_cosim.scenario import Scenario, load_scenario
from amb_cosim.simulation import prepare, run_prepared


def run(
    scenario: str | Path | Scenario,
    *,
    set: Mapping[str, Raw] | None = None,
    until: float | None = None,
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    flavour: Flavour = "python",
    loop: Loop = "compiled",
    progress: bool | Progress | None = None,
) -> Result:
    """Run a scenario and return its result.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of one that comes with the package, or the path of a TOML file.
    set
        Values by `component.variable` that replace the scenario's: `{"rotor_contact.rb1.clearance": "0.6 mm"}`. A
        number is in the unit of the variable.
    until
        End of the run in s from the beginning of cycle 0.
    rotor, receptances
        Rotor file, and table of receptances for the controller's H, in place of the scenario's.
    flavour
        FMUs that PythonFMU runs, or `native` ones that need no Python.
    loop
        `compiled`, or `plain` Python for reference; the results are the same to the last bit.
    progress
        Whether a bar is shown (by default in a terminal and in a notebook), or a function that is called with the steps
        done and their number.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is wrong; the message says where, and what is allowed.
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start. A failure on the way is no exception: `result.outcome` says which
        component failed, when and why.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(str(scenario))
    files = {"rotor": rotor, "receptances": receptances}
    scenario = scenario.model_copy(update={key: str(file) for key, file in files.items() if file is not None})
    with progress_bar(progress) as report:
        return run_prepared(prepare(scenario, set, until, flavour), report, loop)
