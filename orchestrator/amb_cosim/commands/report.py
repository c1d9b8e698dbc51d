"""Command `report`: the statements of the thesis beside what is computed here."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import Failed, refusing
from amb_files.atomic import check_writable
from fmi_export.building.extras import require


@click.command()
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("results/report"),
    show_default=True,
    help="Folder for the page and its data; what fits of an earlier report there is used again.",
)
@click.option("--only", multiple=True, metavar="ch4|fig4_9|...", help="A chapter, figure or table; may be repeated.")
@click.option("--jobs", type=click.IntRange(1, 256), help="Most processes at a time; by default one for a processor.")
def report(output: Path, only: tuple[str, ...], jobs: int | None) -> None:
    """Compute every table, figure and number of the thesis's chapters 2 to 6, and write one page with the verdicts."""
    from rich.console import Console

    from amb_cosim.presentation.progress import bars
    from amb_cosim.report.evaluation import evaluate
    from amb_cosim.report.page import PAGE, write_page
    from amb_cosim.report.table import TABLE, write_table
    from amb_cosim.thesis.verdict import Verdict

    with refusing(), bars(Console(stderr=True)) as shown:
        require("report", "a report", "plotly")
        check_writable(output, is_folder=True)
        task = shown.add_task("computing (a first run compiles the models)", total=None)
        found = evaluate(
            output,
            only,
            jobs,
            lambda done, total: shown.update(task, description="runs and studies", completed=done, total=total),
        )
        found.save_data(output)
        write_table(found, output / TABLE)
        write_page(found, output / PAGE)
    counts = found.counts()
    for verdict in Verdict:
        click.echo(f"{counts[verdict]:4d} {verdict.value}")
    click.echo(f"page in {output / PAGE}")
    if found.failures:
        raise Failed("\n".join(f"{name}: {reason}" for name, reason in found.failures.items()))


COMMANDS = (report,)
