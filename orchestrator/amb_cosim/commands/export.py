"""The command that writes a scenario as an SSP archive."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, RECEPTANCES, ROTOR, SETTINGS
from amb_cosim.cosim.choices import Flavour
from amb_files.atomic import check_writable


@click.command("export-ssp")
@click.argument("name")
@SETTINGS
@click.option("-o", "--output", type=click.Path(path_type=Path), help="The archive; default NAME.ssp.")
@click.option("--until", type=float, metavar="SECONDS", help="End of the run, from the beginning of cycle 0.")
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--connectors",
    is_flag=True,
    help="Make signals and inputs that change connectors of the system; libcosim refuses these.",
)
@click.option("--integers", is_flag=True, help="Describe Enumerations as Integers, for libcosim and ecos.")
def export_ssp(
    name: str,
    settings: tuple[str, ...],
    output: Path | None,
    until: float | None,
    rotor_file: str | None,
    receptances: Path | None,
    flavour: Flavour,
    connectors: bool,
    integers: bool,
) -> None:
    """Write the scenario NAME, or the one in a TOML file, with its FMUs as an SSP 1.0 archive for other tools."""
    import amb_cosim
    from amb_cosim.scenario.plan import parse_settings

    path = output or Path(f"{Path(name).stem}.ssp")
    with refusing():
        check_writable(path, is_folder=False)
        amb_cosim.export_ssp(
            name,
            path,
            set=parse_settings(settings),
            until=until,
            rotor=rotor_file,
            receptances=receptances,
            flavour=flavour,
            connectors=connectors,
            integers=integers,
        )
    click.echo(path)


COMMANDS = (export_ssp,)
