"""The command that builds the FMUs."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import check_writable, refusing
from amb_cosim.commands.options import FLAVOUR, RECEPTANCES, ROTOR
from amb_cosim.cosim.choices import Flavour


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("build"), show_default=True)
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--platform",
    "platforms",
    metavar="NAMES",
    help="linux64, win64, and for native FMUs darwin64, aarch64-linux, aarch64-darwin; some with commas, or all; "
    "this machine's by default.",
)
def build(
    output: Path, rotor_file: str | None, receptances: Path | None, flavour: Flavour, platforms: str | None
) -> None:
    """Build the FMUs into a folder.

    Those of flavour native run in any process. Those of flavour python need Python with NumPy in the process that
    imports them, or on the machine as a shared library."""
    import amb_cosim

    chosen = None if platforms is None else [name.strip() for name in platforms.split(",")]

    with refusing():
        check_writable(output, is_folder=True)
        for path in amb_cosim.build(output, flavour, rotor_file, receptances, chosen):
            click.echo(path)
    if flavour == "python":
        from fmi_export.building.python_fmu import what_it_needs

        click.echo(what_it_needs(), err=True)


COMMANDS = (build,)
