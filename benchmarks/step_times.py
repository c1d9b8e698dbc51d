"""Times of single steps; with real hardware in the loop, the longest must be shorter than a sample."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.presentation.text_tables import labelled_table
from amb_cosim.scenario.file import packaged_scenarios
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from array_types import Array
from benchmarks.baseline import Baseline
from benchmarks.timing import environment
from fmi_export.variables import Enumeration
from rotor_contact.variables.enumerations import CONTACT_MODE, METHOD

SCENARIOS = ("fig4_9", "fig4_14", "rolling_90")  # impacts and rubbing, sustained contact, rolling
TITLE = "Time of single steps, all models (us), and simulated time over the time of all steps"
COLUMNS = ("median", "percentile_99_9", "maximum", "sample", "real_time")


def step_times(rounds: int, names: Sequence[str] = SCENARIOS) -> dict[str, dict[str, Any]]:
    """Return median, 99.9th percentile and maximum of the time (us) of a step, and its sample time, by scenario.

    `real_time` is simulated time over the time of all steps, `longest` what the longest step did. The native models of
    a scenario run in one loop without FMI. All rounds compute the same steps, and the shortest time of each step
    counts, which excludes the load by other programs.

    Raises
    ------
    ValueError
        If a scenario has no baseline.
    """
    return {name: _step_times(name, rounds) for name in names}


def _step_times(name: str, rounds: int) -> dict[str, Any]:
    prepared = prepare_run(load_scenario(name), options=RunOptions(flavour="native"))
    runs = [Baseline(prepared).run(profile=True) for _ in range(rounds)]
    shortest = 1e6 * np.min([run.steps for run in runs], axis=0)
    sample = 1e6 * prepared.step_size
    return {
        "longest": _describe(prepared, runs[0].table, int(shortest.argmax())),
        "median": float(np.median(shortest)),
        "percentile_99_9": float(np.percentile(shortest, 99.9)),
        "maximum": float(shortest.max()),
        "sample": sample,
        "real_time": sample / float(shortest.mean()),
    }


def _describe(plan: Plan, table: Array, step: int) -> dict[str, Any]:
    """Return where a step begins (s), how the plant computed it, and the contact of its sites before and after."""
    before, after = (dict(zip(plan.recorded, table[point], strict=True)) for point in (step, step + 1))
    modes = {name.split(".")[1]: name for name in after if name.startswith("rotor_contact.") and name.endswith(".mode")}
    contact = {site: [_name(CONTACT_MODE, point[name]) for point in (before, after)] for site, name in modes.items()}
    return {
        "begin": plan.time(step),
        "method": _name(METHOD, after["rotor_contact.solver.method"]),
        "contact": contact,
    }


def _name(enumeration: Enumeration, value: float) -> str:
    return enumeration.names[round(value)]


def measure(names: Sequence[str], rounds: int) -> dict[str, Any]:
    """Return `step_times` of scenarios, by default of all that have a baseline, and why others have none."""
    result: dict[str, Any] = {"single_steps_us": {}, "missing": {}, "rounds": rounds, "environment": environment()}
    for name in names or sorted(packaged_scenarios()):
        try:
            result["single_steps_us"] |= step_times(rounds, [name])
        except ValueError as error:
            if names:
                raise
            result["missing"][name] = str(error)
    return result


def as_table(times: dict[str, dict[str, Any]] | None) -> Table:
    """Return what `step_times` returns as a table."""
    table = labelled_table(TITLE, "", "median", "99.9 %", "longest", "sample time", "times real time")
    for name, of_steps in (times or {}).items():
        table.add_row(name, *(f"{of_steps[column]:.3g}" for column in COLUMNS))
    return table


def _sentence(longest: dict[str, Any]) -> str:
    """Return a predicate that describes the longest step: when it begins, method and contact."""
    contact = [
        f"{site} {before}" if before == after else f"{site} {before}, then {after}"
        for site, (before, after) in longest["contact"].items()
        if {before, after} != {"free"}
    ]
    at_sites = "; ".join(contact) or "no contact at its ends"
    return f"begins at {longest['begin']:.6g} s (method: {longest['method']}; {at_sites})"


def as_tables(data: dict[str, Any]) -> list[Table | str]:
    """Return what `measure` returns as a table and lines of text."""
    where = data["environment"]
    return [
        as_table(data["single_steps_us"]),
        *(
            f"{name}: the longest step {_sentence(of_steps['longest'])}"
            for name, of_steps in data["single_steps_us"].items()
        ),
        *(f"{name}: {why}" for name, why in data["missing"].items()),
        f"{where['date']}, {where['processor']}, least of {data['rounds']} rounds, load {where['load_average']}",
    ]
