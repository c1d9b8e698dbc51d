"""The command that identifies the receptances of the levitated rotor."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.console import Console
from rich.progress import Progress, TaskID

from amb_cosim.commands.cli_errors import Failed, check_writable, refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS
from amb_cosim.commands.printing import print_parts
from amb_cosim.cosim.fmus import Flavour
from amb_cosim.progress import STARTING, bars

if TYPE_CHECKING:
    from amb_analysis.table_file import ReceptanceTable
    from amb_cosim.simulation import Prepared
    from amb_cosim.studies.receptance_measurement import Identified


@click.command()
@click.option(
    "--speeds",
    metavar="LIST",
    help="Spin speeds with commas, each in rad/s or with its unit (5 Hz,10 Hz); the thesis's twelve by default.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default="receptances.toml",
    show_default=True,
    help="Table of receptances; what it holds of other speeds stays.",
)
@ROTOR
@SETTINGS
@FLAVOUR
def identify(
    speeds: str | None, output: Path, rotor_file: Path | None, settings: tuple[str, ...], flavour: Flavour
) -> None:
    """Identify the receptances of the levitated rotor, as its controller does, and keep them in a table.

    Give the table to `run` or `build` with --receptances. It is written after each speed.
    """
    from amb_analysis.receptance_table import SPEEDS
    from amb_cosim.studies import receptance_measurement
    from amb_cosim.studies.modal import speed_list

    console = Console(stderr=True)
    with refusing():
        check_writable(output, is_folder=False)
        chosen = SPEEDS if speeds is None else speed_list(speeds)
        with console.status("preparing the FMUs"):
            runs = [receptance_measurement.prepared_run(Omega, rotor_file, settings, flavour) for Omega in chosen]
            table = receptance_measurement.table_for(runs[0], output)
        results = _results(runs, table, output, console)
    print_parts([receptance_measurement.as_table(results)])
    done = sum(result.receptance is not None for result in results)
    kept = f"{output} has the {done} done" if done else f"nothing was written to {output}"
    if results[-1].interrupted:
        raise Failed(f"{results[-1].reason}; {kept}")
    if done < len(runs):
        raise Failed(f"identification failed at {len(runs) - done} of {len(runs)} speeds; {kept}")
    click.echo(f"receptances in {output}")


def _results(runs: list[Prepared], table: ReceptanceTable, output: Path, console: Console) -> list[Identified]:
    """Run one identification after the other, until Ctrl-C, and write the table after each that succeeds."""
    from amb_cosim.studies import receptance_measurement

    results = []
    with bars(console) as shown:
        every, one = shown.add_task("speeds", total=len(runs)), shown.add_task(STARTING, total=None)
        for prepared in runs:
            report = partial(_report, shown, one, f"{prepared.plan.speed / (2.0 * math.pi):.4g} Hz")
            result = receptance_measurement.identified(prepared, report)
            if result.receptance is not None:
                table = table.updated(result.Omega, result.receptance, result.order)
                table.write(output)
            results.append(result)
            shown.advance(every)
            if result.interrupted:
                break
    return results


def _report(shown: Progress, task: TaskID, label: str, done: int, total: int) -> None:
    shown.update(task, description=label, completed=done, total=total)


COMMANDS = (identify,)
