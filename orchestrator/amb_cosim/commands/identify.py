"""The command that identifies the receptances of the levitated rotor."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim import studies
from amb_cosim.commands.cli_errors import Failed, interrupted, refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS
from amb_cosim.cosim.choices import Flavour
from amb_files.atomic import check_writable


@click.command()
@click.option(
    "--speeds",
    metavar="LIST",
    help="Spin speeds with commas, each in rad/s or with its unit (5 Hz,10 Hz); twelve from 5 to 35 Hz by default.",
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
    speeds: str | None, output: Path, rotor_file: str | None, settings: tuple[str, ...], flavour: Flavour
) -> None:
    """Identify the receptances of the levitated rotor, as its controller does, and keep them in a table.

    Give the table to `run` or `build` with --receptances. It is written after each speed.
    """
    from amb_cosim.presentation.text_tables import print_parts
    from amb_cosim.scenario.plan import parse_settings

    with refusing():
        check_writable(output, is_folder=False)
        values = parse_settings(settings)
        result = studies.identify(speeds, output=output, rotor=rotor_file, set=values, flavour=flavour)
    print_parts(result.text())
    written = f"{output} has the {result.identified} done" if result.identified else f"nothing was written to {output}"
    if result.interruption:
        raise interrupted(f"{result.interruption}; {written}")
    missing = len(result.speeds) - result.identified
    if missing:
        raise Failed(f"identification failed at {missing} of {len(result.speeds)} speeds; {written}")
    click.echo(f"receptances in {output}")


COMMANDS = (identify,)
