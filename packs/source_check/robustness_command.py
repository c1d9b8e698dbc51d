"""Command `robustness`: which of the outcomes that a pack has and states are robust."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from amb_cosim.commands.cli_errors import Failed, refusing

if TYPE_CHECKING:
    from amb_cosim.cosim.system.values import Raw
    from amb_cosim.scenario.scenario import Scenario
    from amb_cosim.studies.stored_robustness import StoredOutcome


@dataclass(frozen=True)
class OutcomeCase:
    """A scenario, or a run that statements rest on, by its name."""

    name: str
    scenario: Scenario
    settings: dict[str, Raw]


@click.command()
@click.argument("pack")
@click.option("--only", multiple=True, metavar="NAME", help="A scenario, or a source of statements; may be repeated.")
@click.option("--jobs", type=click.IntRange(1, 256), help="Most processes at a time; by default one for a processor.")
def robustness(pack: str, only: tuple[str, ...], jobs: int | None) -> None:
    """Check and store which outcomes of a pack are robust.

    Its runs are repeated with H identified and with 1 % more and less of each quantity.

    The report and pages show what is kept. `study robustness` shows one scenario with all figures.
    """
    from rich.console import Console

    from amb_cosim.presentation.progress import bars
    from amb_cosim.studies.processes import simulate_in_processes
    from amb_cosim.studies.stored_robustness import write_robustness
    from amb_files.temporary_folders import temporary_folder

    retained = 0
    failures: dict[str, str] = {}
    with temporary_folder() as folder, refusing(), bars(Console(stderr=True)) as displayed:
        cases = outcome_cases(pack, folder, only)
        task = displayed.add_task("scenarios", total=len(cases))
        for begin in range(0, len(cases), BATCH):
            batch = cases[begin : begin + BATCH]
            result = simulate_in_processes(outcome_of_case, batch, lambda *_: None, jobs)
            results = {case.name: item for case, item in zip(batch, result, strict=True) if not isinstance(item, str)}
            failures |= {case.name: item for case, item in zip(batch, result, strict=True) if isinstance(item, str)}
            file, retained = write_robustness(pack, results), retained + len(results)
            displayed.update(task, completed=begin + len(batch))
    click.echo(f"{retained} outcomes in {file}")
    if failures:
        raise Failed("\n".join(f"{name}: {reason}" for name, reason in failures.items()))


BATCH = 8  # cases between two writes of the file


def outcome_cases(pack: str, folder: Path, only: tuple[str, ...] = ()) -> list[OutcomeCase]:
    """Return the runs of a pack: its scenarios, and those that its statements rest on and that differ from them.

    Parameters
    ----------
    pack
        Its name.
    folder
        Where rotor files are written that sources change.
    only
        Names of those that are wanted; all without.

    Raises
    ------
    ValueError
        If there is no such pack, or none of its runs has a name that is given.
    """
    from amb_cosim.scenario.scenario import load_scenario
    from amb_files.packs import packs
    from amb_files.suggestions import suggest
    from source_check.source_runs import scenario_of
    from source_check.statements import load_statements, packs_with_statements

    if pack not in packs():
        raise ValueError(f"there is no pack {pack!r}; {suggest(pack, packs())}")
    names = sorted(file.stem for file in (packs()[pack] / "scenarios").glob("[!_]*.toml"))
    cases = [OutcomeCase(name, load_scenario(name), {}) for name in names]
    stated = load_statements(pack) if pack in packs_with_statements() else None
    beside = {statement.converged for statement in stated.statement} if stated is not None else set()
    for name, source in stated.sources.items() if stated is not None else ():
        if source.scenario and name not in beside.union(names):
            cases.append(OutcomeCase(name, scenario_of(source, folder / f"{name}.toml"), dict(source.set)))
    unknown = [name for name in only if name not in {case.name for case in cases}]
    if unknown:
        raise ValueError(f"--only {unknown[0]} is not allowed; {suggest(unknown[0], [case.name for case in cases])}")
    if not cases:
        raise ValueError(f"pack {pack!r} has no scenarios and no statements of one")
    return [case for case in cases if not only or case.name in only]


def outcome_of_case(case: OutcomeCase) -> StoredOutcome | str:
    """Return the outcome of a run and what flips it, or why there is none."""
    from amb_cosim.studies.stored_robustness import StoredOutcome
    from amb_cosim.sweeps.robustness import robustness as study

    try:
        result = study(case.scenario, set=case.settings, progress=False)
    except ValueError as error:
        return str(error)
    return StoredOutcome(outcome=result.outcome, flips=result.flips)
