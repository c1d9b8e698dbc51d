"""The command that checks a machine file or judges whether the machine may run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import click

from amb_cosim.commands.cli import main
from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, UNITS, output
from amb_cosim.cosim.choices import Flavour
from amb_files.atomic import check_writable
from fmi_export.building.extras import lacking_extra


@click.command()
@click.argument("file")
@output("Folder for page, data and PDF; default results/assess_NAME.")
@click.option("--only", multiple=True, metavar="PART", help="Part to compute, such as closed_loop; repeatable.")
@click.option(
    "--criteria",
    multiple=True,
    metavar="NAME|FILE",
    help="Criteria that replace the machine file's; repeatable.",
)
@click.option("--check", is_flag=True, help="Check the file and print its content, without verdicts.")
@click.option("--pdf/--no-pdf", default=True, help="Print the page as PDF with an installed browser.")
@UNITS
@FLAVOUR
def assess(
    file: str,
    output: Path | None,
    only: tuple[str, ...],
    criteria: tuple[str, ...],
    check: bool,
    pdf: bool,
    flavour: Flavour,
) -> None:
    """Assess a machine against API 617 and ISO 14839.

    The page shows a verdict for each criterion and suggests changes. FILE may be the name of a packaged machine.

    Of the 31 packaged criteria, 15 were written without access to the text of their standard. The page cites each
    source.

    The exit code is 0 if all parts and criteria could be assessed and no loop is unstable, regardless of other
    verdicts; otherwise it is 1.
    """
    if check:
        _print_description(file, criteria, flavour)
        return
    from amb_assessment.assessment.engine.assess import assess as assessment_of
    from amb_assessment.assessment.format.machine_file import load_machine
    from amb_assessment.assessment.page.page import DATA, PAGE, write_data, write_page
    from amb_assessment.assessment.page.pdf import PDF, print_page
    from amb_cosim.commands.cli_errors import Failed
    from amb_cosim.presentation.text_tables import print_parts, show_warnings
    from amb_cosim.presentation.units import convert_units_in_text

    with refusing():
        without_page = lacking_extra("report", "the page", "plotly")
        machine = load_machine(file)
        folder = output or Path("results") / re.sub(r"[/\\]", "_", f"assess_{machine.name}")
        check_writable(folder, is_folder=True, files=(PAGE, DATA, PDF))
        result = assessment_of(machine, only=only, criteria=criteria, flavour=flavour)
        data = write_data(result, folder)
        page = None if without_page else write_page(result, folder)
        printed = print_page(page) if page and pdf else None
    undecided = {key: why for key, why in result.undecided.items() if key not in result.unevaluated}
    sentences = [*(sentence for _, sentence in result.failures), *_by_reason(_named(undecided))]
    print_parts([result.conclusion, *(f"  {sentence}" for sentence in sentences)])
    click.echo(f"page in {page}" + (f", printed in {printed}" if printed else "") if page else f"data in {data}")
    show_warnings(filter(None, [*result.warnings, without_page]))
    failures = _by_reason(result.unanswered | _named(result.unevaluated))
    if result.instability:
        failures.insert(0, f"the machine is not stable: {result.instability}")
    if failures:
        raise Failed(convert_units_in_text("\n".join(failures)))


def _named(criteria: Mapping[str, str]) -> dict[str, str]:
    return {f"criterion {key}": why for key, why in criteria.items()}


def _by_reason(unanswered: Mapping[str, str]) -> list[str]:
    """Return a line for each reason, with the names of the parts or criteria that it leaves unanswered."""
    return [
        f"{', '.join(name for name, why in unanswered.items() if why == reason)}: unanswered, because {reason}"
        for reason in dict.fromkeys(unanswered.values())
    ]


def _print_description(file: str, criteria: tuple[str, ...], flavour: Flavour) -> None:
    """Check a machine file, its criteria and their formulas, and print the content of the file."""
    from amb_assessment.assessment.engine.assess import check_machine
    from amb_assessment.assessment.format.criteria import check_criteria, load_criteria
    from amb_assessment.assessment.format.machine_file import load_machine
    from amb_assessment.assessment.page.description import description
    from amb_cosim.presentation.text_tables import print_parts

    with refusing():
        machine = load_machine(file)
        chosen = load_criteria(criteria or machine.criteria)
        subject = check_machine(machine, flavour)
        check_criteria(chosen, subject.facts)
        parts = description(subject, chosen)
    print_parts(parts)


main.add_section("Design and judge", assess)
main.add_examples({"assess": ("assess turbo_expander", "assess pump/machine.toml --only closed_loop")})
