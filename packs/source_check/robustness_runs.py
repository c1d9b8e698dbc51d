"""Robustness of the outcomes of a pack's scenarios and statements, for `amb-cosim report --robustness`."""

from __future__ import annotations

from dataclasses import dataclass

import click

from amb_analysis.studies.processes import simulate_in_processes
from amb_cosim.commands.cli_errors import refusing
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.progress import bars
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_files import packs
from amb_files.suggestions import suggest
from amb_sweeps.stored_robustness import StoredOutcome, write_robustness
from source_check.source_runs import scenario_of
from source_check.statements import load_statements, packs_with_statements

BATCH = 8  # cases between two writes of the file


@dataclass(frozen=True)
class OutcomeCase:
    """A scenario, or a run for statements, with its name."""

    name: str
    scenario: Scenario
    settings: dict[str, Raw]


def store_robustness(pack: str, only: tuple[str, ...], jobs: int | None) -> dict[str, str]:
    """Repeat the runs of a pack, store which outcomes are robust, and return the reason for each failure, by run.

    Each run is repeated as by `study robustness`: with H identified, and with changes of each quantity. The report and
    the pages show the stored results.
    """
    stored = 0
    failures: dict[str, str] = {}
    with refusing(), bars(plain_console(stderr=True)) as progress_bars:
        cases = outcome_cases(pack, only)
        task = progress_bars.add_task("scenarios", total=len(cases))
        for begin in range(0, len(cases), BATCH):
            batch = cases[begin : begin + BATCH]
            answers = simulate_in_processes(outcome_of_case, batch, lambda *_: None, jobs)
            outcomes = {case.name: item for case, item in zip(batch, answers, strict=True) if not isinstance(item, str)}
            failures |= {case.name: item for case, item in zip(batch, answers, strict=True) if isinstance(item, str)}
            file, stored = write_robustness(pack, outcomes), stored + len(outcomes)
            done = begin + len(batch)
            progress_bars.update(task, description=f"{done} of {len(cases)} scenarios", completed=done)
    click.echo(f"{stored} outcomes in {file}")
    return failures


def outcome_cases(pack: str, only: tuple[str, ...] = ()) -> list[OutcomeCase]:
    """Return the runs of a pack: its scenarios, and any other runs that its statements require.

    Parameters
    ----------
    pack
        Name of the pack.
    only
        Names of the requested runs; by default all.

    Raises
    ------
    ValueError
        If there is no such pack, or `only` contains a name without a run.
    """
    if pack not in packs.packs():
        raise ValueError(f"there is no pack {pack!r}; {suggest(pack, packs.packs())}")
    names = sorted(file.stem for file in (packs.packs()[pack] / "scenarios").glob("[!_]*.toml"))
    cases = [OutcomeCase(name, load_scenario(name), {}) for name in names]
    if pack in packs_with_statements():
        statements = load_statements(pack)
        converged = {statement.converged for statement in statements.statement}
        for name, source in statements.sources.items():
            if source.scenario and name not in converged.union(names):
                cases.append(OutcomeCase(name, scenario_of(source), dict(source.set)))
    unknown = [name for name in only if name not in {case.name for case in cases}]
    if unknown:
        raise ValueError(f"only = {unknown[0]} is not allowed; {suggest(unknown[0], [case.name for case in cases])}")
    if not cases:
        raise ValueError(f"pack {pack!r} has neither scenarios nor statements about one")
    return [case for case in cases if not only or case.name in only]


def outcome_of_case(case: OutcomeCase) -> StoredOutcome | str:
    """Return the outcome of a run and the changes that flip it, or the reason for a failure."""
    from amb_sweeps.robustness import robustness

    try:
        result = robustness(case.scenario, set=case.settings, progress=False)
    except ValueError as error:
        return str(error)
    return StoredOutcome(outcome=result.outcome, flips=result.flips, untested=result.untested)
