"""The command that identifies the receptances of the levitated rotor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_analysis import studies
from amb_cosim.commands.cli_errors import Failed, interrupted, refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS, SPEED, UNITS, output
from amb_cosim.cosim.errors import computed_by
from amb_files.atomic import check_writable


@click.command()
@click.option(
    "--speeds",
    type=SPEED,
    metavar="LIST",
    help="Spin speeds (5 Hz,10 Hz); default: twelve, 5 to 35 Hz.",
)
@output("Table of receptances to write; its other speeds are kept.", "receptances.toml")
@click.option("--scenario", metavar="NAME|FILE", help="Scenario that provides machine and parameters.")
@ROTOR
@SETTINGS
@FLAVOUR
@click.option("--computed", is_flag=True, help="Compute from the linear model, without simulation.")
@UNITS
def identify(output: Path, **options: Any) -> None:
    """Identify receptances of the levitated rotor.

    The controller identifies them in a co-simulation and writes a table after each speed.

    Pass the table to `run` or `build` with --receptances.
    """
    from amb_cosim.presentation.text_tables import print_parts

    with refusing():
        check_writable(output, is_folder=False)
        result = computed_by(studies.identify, output=output, **options)
    print_parts(result.text())
    written = (
        f"{output} contains the receptances at {result.identified} speed{'s' * (result.identified != 1)}"
        if result.identified
        else f"nothing was written to {output}"
    )
    if result.interruption:
        raise interrupted(f"{result.interruption}; {written}")
    missing = len(result.speeds) - result.identified
    if missing:
        raise Failed(f"identification failed at {missing} of {len(result.speeds)} speeds; {written}")
    click.echo(f"receptances in {output}")
