"""Commands of a machine file: `machine check` looks at one, `assess` says whether the machine may run."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, UNITS, output
from amb_cosim.cosim.basics.choices import Flavour
from amb_files.atomic import check_writable
from fmi_export.building.extras import require_extra


@click.group()
def machine() -> None:
    """Check machine files."""


@machine.command("check")
@click.argument("file")
@FLAVOUR
def check(file: str, flavour: Flavour) -> None:
    """Check a machine FILE and print what it describes.

    In place of a FILE, the name of a machine of a pack may be given.
    """
    from amb_cosim.assessment.assess import check_machine
    from amb_cosim.assessment.criteria import check_formulas, load_criteria
    from amb_cosim.assessment.description import description
    from amb_cosim.assessment.machine_file import load_machine
    from amb_cosim.presentation.text_tables import print_parts

    with refusing():
        result = load_machine(file)
        criteria = load_criteria(result.criteria)
        subject = check_machine(result, flavour)
        check_formulas(criteria, subject.facts)
        parts = description(subject, criteria)
    print_parts(parts)


@click.command()
@click.argument("file")
@output("Folder for page, data and PDF; default results/assess_NAME.")
@click.option("--only", multiple=True, metavar="PART", help="A part, such as closed_loop; may be repeated.")
@click.option(
    "--criteria",
    multiple=True,
    metavar="NAME|FILE",
    help="Criteria in place of those of the machine file; may be repeated.",
)
@click.option("--pdf/--no-pdf", default=True, help="Whether a browser prints the page as PDF, where there is one.")
@UNITS
@FLAVOUR
def assess(
    file: str, output: Path | None, only: tuple[str, ...], criteria: tuple[str, ...], pdf: bool, flavour: Flavour
) -> None:
    """Assess a machine against API 617 and ISO 14839.

    One page has the verdicts by criteria, and what to change. The machine is that of a FILE, or of a pack.

    Exit code 0 says that all parts are answered, whatever the verdicts.
    """
    from rich.console import Console

    from amb_cosim.assessment.assess import assess as answer
    from amb_cosim.assessment.findings import Judgement
    from amb_cosim.assessment.machine_file import load_machine
    from amb_cosim.assessment.page import write_assessment
    from amb_cosim.assessment.pdf import print_page
    from amb_cosim.commands.cli_errors import Failed
    from amb_cosim.presentation.progress import bars

    with refusing(), bars(Console(stderr=True)) as displayed:
        require_extra("report", "an assessment", "plotly")
        read = load_machine(file)
        folder = output or Path("results") / f"assess_{read.name}"
        check_writable(folder, is_folder=True)
        task = displayed.add_task("preparing (a first run compiles the models)", total=None)
        result = answer(
            read,
            only=only,
            criteria=criteria,
            flavour=flavour,
            progress=lambda title, done, total: displayed.update(task, description=title, completed=done, total=total),
        )
        page = write_assessment(result, folder)
        printed = print_page(page) if pdf else None
    for item in result.missed:
        what = item.criterion.what if item.criterion else item.measured.quantity
        click.echo(f"missed: {what}: {item.value_text} ({item.limit_text}), {item.measured.where}")
    counts = result.counts()
    click.echo(", ".join(f"{counts[verdict]} {verdict.value}" for verdict in Judgement))
    click.echo(f"page in {page}" + (f", printed in {printed}" if printed else ""))
    if result.unanswered:
        raise Failed("\n".join(f"{name}: not answered, because {reason}" for name, reason in result.unanswered.items()))


COMMANDS = (machine, assess)
