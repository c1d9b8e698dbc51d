"""The command `report`, which compares statements of packs with computed values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from amb_cosim.commands.cli_errors import Failed, Refused, refusing
from amb_cosim.commands.options import UNITS, output
from amb_files.atomic import check_writable, write_file
from fmi_export.building.extras import require_extra

if TYPE_CHECKING:
    from source_check.evaluation import Report
    from source_check.statements import Statements


@click.command()
@output("Folder for page and data; matching results are reused.", "results/report")
@click.option(
    "--pack",
    "packs",
    multiple=True,
    metavar="NAME",
    help="Pack with statements; default: all that match --only.",
)
@click.option("--only", multiple=True, metavar="NAME", help="A chapter, figure or table: ch4, table3_1; repeatable.")
@click.option("--jobs", type=click.IntRange(1, 256), help="Number of processes; default: one per processor.")
@click.option(
    "--robustness",
    is_flag=True,
    help="Check and store which outcomes of each --pack are robust; write no page.",
)
@UNITS
def report(output: Path, packs: tuple[str, ...], only: tuple[str, ...], jobs: int | None, robustness: bool) -> None:
    """Check the statements of packs and write a page of verdicts.

    If there are several packs, each pack has its own folder.
    """
    from source_check.robustness_runs import store_robustness
    from source_check.statements import load_statements, packs_with_statements

    failures: dict[str, str] = {}
    if robustness:
        if not packs:
            raise Refused("--robustness needs --pack NAME")
        for pack in packs:
            failures |= store_robustness(pack, only, jobs)
        _fail(failures)
        return
    with refusing():
        check_writable(output, is_folder=True)
        by_pack = {pack: load_statements(pack) for pack in packs or packs_with_statements()}
    with_all = {pack: statements for pack, statements in by_pack.items() if statements.named.keys() >= {*only}}
    chosen = with_all or by_pack
    for pack, statements in chosen.items():
        folder = output if len(chosen) == 1 else output / pack
        failures |= _assess(statements, folder, only, jobs, pack).failures
    _fail(failures)


def _fail(failures: dict[str, str]) -> None:
    if failures:
        raise Failed("\n".join(f"{name}: {reason}" for name, reason in failures.items()))


def _assess(statements: Statements, folder: Path, only: tuple[str, ...], jobs: int | None, pack: str) -> Report:
    """Compute and judge statements, write data, table and page into a folder, and print the count of each verdict."""
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.presentation.progress import bars
    from amb_sweeps.stored_robustness import load_robustness
    from source_check.evaluation import DATA, assess
    from source_check.page import PAGE, page
    from source_check.table import TABLE, markdown
    from source_check.verdict import Verdict

    with refusing(), bars(plain_console(stderr=True)) as progress_bars:
        require_extra("report", "a report", "plotly")
        task = progress_bars.add_task("computing (the first run compiles the models)", total=None)

        def progress(done: int, total: int) -> None:
            text = f"{done} of {total} runs and studies"
            progress_bars.update(task, description=text, completed=done, total=total)

        result = assess(statements, folder, only, jobs, progress, load_robustness(pack))
        for name, text in ((DATA, result.to_json()), (TABLE, markdown(result)), (PAGE, page(result))):
            write_file(folder / name, text)
    counts = result.counts()
    for verdict in Verdict:
        click.echo(f"{counts[verdict]:4d} {verdict.value}")
    click.echo(f"page in {folder / PAGE}")
    return result
