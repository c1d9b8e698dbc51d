"""Study of how contact forces converge with modes, mesh, substep and communication step, with perturbed starts.

A contact force has converged if neither twice as many modes nor a shorter communication step changes it. If changing
the clearances by a millionth changes the runs substantially, the case is chaotic. A single run then proves nothing, so
medians over many starts are compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.convergence_runs import (
    START,
    STEP_PARTS,
    CaseResult,
    Contact,
    ConvergenceCase,
    prepare_case,
    simulate_case,
    varied_cases,
)
from amb_analysis.studies.processes import simulate_in_processes
from amb_analysis.studies.result import MachineResult
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import Progress, RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number, text_table
from amb_cosim.results.contact_forces import WINDOW
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.checks import require
from amb_files.plain_values import plain_values
from array_types import Array
from rotor_analysis.rotor_file import load_rotor

ORDER = ("scenario", "modes", "mesh", "substep", "step")
CONVERGED = 0.05  # relative change of a force between impacts
CHAOTIC = 0.05  # relative scatter of a force between impacts over starts


@dataclass(frozen=True)
class ConvergenceRow:
    """A run in the result: the varied quantity, label, number for sorting, number of the start, and `CaseResult`.

    change
        Largest relative change (%) of a site's largest force between impacts, compared with the run of the scenario;
        None if there is no contact.
    """

    varied: str
    label: str
    value: float
    start: int
    sites: dict[str, Contact]
    recovery: str | None
    energy_balance: float | None
    failure: str
    change: Annotated[float | None, "%"]


@dataclass(frozen=True, eq=False, repr=False)
class ContactConvergence(MachineResult):
    """Contact in a scenario, with varied modes, meshes, substeps, communication steps and starts.

    rows
        The run of the scenario, followed by the others.
    scatter
        Largest scatter of a force between impacts over the starts, (largest - smallest) / median (%); None if there
        are no perturbed starts.
    change
        Largest change of a force between impacts with twice as many modes (%); None if modes do not vary. If the case
        is chaotic, medians over the starts are compared.
    step_change
        Largest change of a force between impacts with the shortest communication step (%), computed like `change`.
    averaged_change, averaged_step_change
        `change` and `step_change` for the force averaged over 1 ms.
    chaotic
        Whether the scatter shows chaos; None if there are no perturbed starts.
    """

    name: ClassVar[str] = "convergence"

    rows: tuple[ConvergenceRow, ...]
    scatter: Annotated[float | None, "%"]
    change: Annotated[float | None, "%"]
    step_change: Annotated[float | None, "%"]
    averaged_change: Annotated[float | None, "%"]
    averaged_step_change: Annotated[float | None, "%"]
    chaotic: bool | None

    def text(self) -> list[TextBlock]:
        """Return a table of forces between impacts, impulses and outcomes, and lines that explain it."""
        sites = list(dict.fromkeys(site for row in self.rows for site in row.sites))
        columns = ("between impacts (N)", "1 ms (N)", "impact (N s)", "integral (N s)")
        headings = [f"{name_label(site)} {what}" for site in sites for what in columns]
        title = f"Convergence of {self.scenario} with {self.rotor}"
        table = text_table(title, ("run", *headings, "change", "outcome"), left=("run", "outcome"))
        for row in self.rows:
            if row.start == 0:
                cells = [text for site in sites for text in _cells(row.sites.get(site))]
                change = "-" if row.change is None else f"{row.change:.1f} %"
                table.add_row(row.label, *cells, change, row.failure or row.recovery or "-")
        window = f"{1e3 * WINDOW:g} ms: largest contact force (mean over this time, impacts included)"
        return [
            table,
            f"between impacts: largest force without impacts; {window}; "
            "impact: largest impulse of impacts in one step; integral: of the normal force over time, impacts included",
            *self._over_starts(sites),
            *self._verdict(),
            *self.warning_lines(),
        ]

    def _over_starts(self, sites: Sequence[str]) -> list[TextBlock]:
        """Return a table of the forces over the starts, for the scenario and for the run with the most modes."""
        repeated = list(dict.fromkeys(row.label for row in self.rows if row.start))
        if not repeated:
            return []
        headings = [
            f"{name_label(site)} {what}" for site in sites for what in ("least (N)", "median (N)", "greatest (N)")
        ]
        table = labelled_table("Largest force between impacts over the starts", "run", *headings)
        for label in repeated:
            runs = [row for row in self.rows if row.label == label]
            peaks = [[row.sites[site].peak_force for row in runs if site in row.sites] for site in sites]
            cells = [[np.min(peak), np.median(peak), np.max(peak)] if peak else [None] * 3 for peak in peaks]
            table.add_row(label, *(number(value) for values in cells for value in values))
        return [table]

    def _verdict(self) -> list[str]:
        lines = []
        if self.scatter is not None:
            starts = max(row.start for row in self.rows)
            verdict = "chaotic, medians are compared" if self.chaotic else "not chaotic"
            scatter = f"forces between impacts scatter by {self.scatter:.2g} %"
            lines.append(f"{verdict}: over {starts} starts with clearances {START:g} apart, {scatter}")
        for what, change, averaged in (
            (f"a communication step of 1/{STEP_PARTS[-1]}", self.step_change, self.averaged_step_change),
            ("twice as many coordinates, or the full model", self.change, self.averaged_change),
        ):
            if change is not None:
                verdict = "converged" if change <= 100.0 * CONVERGED else "not converged"
                forces = (
                    f"forces between impacts change by up to {change:.2g} %, averages over 1 ms by {averaged:.2g} %"
                )
                lines.append(f"{verdict}: with {what}, {forces}")
        return lines


def _cells(contact: Contact | None) -> Sequence[str]:
    if contact is None:
        return "-", "-", "-", "-"
    return tuple(number(value) for value in vars(contact).values())


def convergence(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | None = None,
    set: Mapping[str, Raw] | None = None,
    starts: int = 4,
    flavour: Flavour = "native",
    progress: bool | Progress | None = None,
) -> ContactConvergence:
    """Return the contact forces and the outcome of a scenario for varied modes, mesh, substep, step and start.

    For the runs with other modes, the number of elastic modes in the plant's model of the rotor is halved and doubled.
    A rotor without reduction has no such runs. The meshes have the accuracies 1e-2, 1e-3 and, for a consistent mass
    matrix, 1e-4 (`accuracy` in `[mesh]`). One run has the mesh of the rotor file with the other kind of mass matrix
    (`diagonal` or `consistent`).

    Parameters
    ----------
    scenario
        A `Scenario`, the name of a packaged scenario, or a TOML file; by default the packs' default scenario.
    rotor
        Name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    set
        Values by `component.variable` that replace the scenario's.
    starts
        Number of perturbed starts, whose clearances differ by a relative 1e-6 from one start to the next. The study
        makes this many additional runs for the scenario, for twice as many modes, and for the shortest communication
        step.
    flavour
        Flavour of the FMUs.
    progress
        Whether to display a bar (default in a terminal and a notebook), or a function that is called with the number of
        finished runs and the number of all runs.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid, or if the run of the scenario does not reach its end.
    """
    require(0 <= starts <= 1000, "starts", starts, "from 0 to 1000")
    values = as_scenario(scenario, rotor)
    base = ConvergenceCase(values, plain_values(set, "set"), RunOptions(flavour=flavour))
    prepared = prepare_case(base)  # checks the input and builds the FMUs before processes are started
    with progress_bar(progress) as report:
        variants = list(varied_cases(base))
        base_cases = _with_starts([base], starts)
        more_modes, short_steps = (_with_starts(_furthest(variants, varied), starts) for varied in ("modes", "step"))
        repeated = [*base_cases, *more_modes, *short_steps]
        cases = [*repeated, *(case for case in variants if case not in repeated)]
        results = simulate_in_processes(simulate_case, cases, report)
    if results[0].failure:
        raise ValueError(f"scenario {values.name}: {results[0].failure}")
    rows = [_row(case, result, results[0]) for case, result in zip(cases, results, strict=True)]
    rows.sort(key=lambda row: (row.start, ORDER.index(row.varied), row.value))
    base_results, others = results[: len(base_cases)], results[len(base_cases) : len(repeated)]
    modes_results, step_results = others[: len(more_modes)], others[len(more_modes) :]
    scatter = _scatter(base_results) if starts else None
    chaotic = None if scatter is None else scatter > 100.0 * CHAOTIC
    compared = slice(None) if chaotic else slice(1)
    change, step_change, averaged_change, averaged_step_change = (
        _change(other[compared], base_results[compared], force) if other else None
        for force in ("peak_force", "mean_force")
        for other in (modes_results, step_results)
    )
    return ContactConvergence(
        scenario=values.name,
        rotor=load_rotor(values.rotor).name,
        rows=tuple(rows),
        scatter=scatter,
        change=change,
        step_change=step_change,
        averaged_change=averaged_change,
        averaged_step_change=averaged_step_change,
        chaotic=chaotic,
        warnings=prepared.warnings,
    )


def _furthest(cases: Sequence[ConvergenceCase], varied: str) -> list[ConvergenceCase]:
    """Return, in a list, the case with the most modes or the shortest communication step, if there is one."""
    return sorted((case for case in cases if case.varied == varied), key=lambda case: case.value)[-1:]


def _with_starts(cases: Sequence[ConvergenceCase], starts: int) -> list[ConvergenceCase]:
    """Return the cases, each followed by its repetitions from perturbed starts."""
    return [replace(case, start=k) for case in cases for k in range(starts + 1)]


def _row(case: ConvergenceCase, result: CaseResult, base: CaseResult) -> ConvergenceRow:
    change = _change([result], [base]) if result.sites else None
    return ConvergenceRow(case.varied, case.label, case.value, case.start, **vars(result), change=change)


def _forces(results: Sequence[CaseResult], force: str) -> dict[str, Array]:
    """Return the `peak_force` or `mean_force` of each run, by site, for all sites that any run touched."""
    sites = dict.fromkeys(site for result in results for site in result.sites)
    return {s: np.array([getattr(r.sites[s], force) if s in r.sites else 0.0 for r in results]) for s in sites}


def _scatter(results: Sequence[CaseResult]) -> float:
    """Return the scatter of the force (%), (largest - smallest) / median, at the site with the largest scatter."""
    return max(
        (100.0 * float(np.ptp(f) / np.median(f)) for f in _forces(results, "peak_force").values() if f.any()),
        default=0.0,
    )


def _change(results: Sequence[CaseResult], base: Sequence[CaseResult], force: str = "peak_force") -> float:
    """Return the relative change of the median of a force (%), at the site with the largest change."""
    before, after = ({s: float(np.median(f)) for s, f in _forces(runs, force).items()} for runs in (base, results))
    return max(
        (100.0 * abs(after.get(site, 0.0) / value - 1.0) for site, value in before.items() if value > 0.0), default=0.0
    )
