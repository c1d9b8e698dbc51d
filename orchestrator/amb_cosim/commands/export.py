"""The command that writes a scenario as an SSP archive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, PLATFORMS, RECEPTANCES, ROTOR, SETTINGS, UNTIL, output
from amb_files.atomic import check_writable


@click.command("export-ssp")
@click.argument("name")
@SETTINGS
@output("Archive to write; default: NAME.ssp.")
@UNTIL
@ROTOR
@RECEPTANCES
@FLAVOUR
@PLATFORMS
@click.option(
    "--connectors",
    is_flag=True,
    help="Add system connectors for inputs (not for libcosim).",
)
@click.option("--integers", is_flag=True, help="Describe Enumerations as Integers, for libcosim and ecos.")
def export_ssp(name: str, output: Path | None, **options: Any) -> None:
    """Write a scenario with its FMUs as an SSP archive.

    NAME is a scenario or its TOML file. The archive is SSP 1.0, for other tools.
    """
    from amb_cosim.export import exchange

    path = output or Path(f"{Path(name).stem}.ssp")
    with refusing():
        check_writable(path, is_folder=False)
        exchange.export_ssp(name, path, **options)
    click.echo(path)


COMMANDS = (export_ssp,)
