"""The command that builds the FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, FMI, PLATFORMS, RECEPTANCES, ROTOR, output
from amb_cosim.cosim.basics.choices import Flavour
from amb_files.atomic import check_writable

SYSTEM = "levitated"  # what is assembled without a scenario


@click.command()
@output("Folder for the FMUs.", "build")
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--assembled",
    is_flag=False,
    flag_value=SYSTEM,
    metavar="[SCENARIO]",
    help="One FMU, levitated_rotor, in place of three: rotor, actuator and controller stepped together, with the "
    "scenario's values (name or TOML file) to start with; without one those of the system levitated. Of a system file, "
    "one FMU of all its components.",
)
@click.option(
    "--scenario",
    metavar="SCENARIO",
    help="The FMUs of a scenario's components (name, TOML or system file), with its parameters and first inputs as "
    "start values, for masters that are wired by hand.",
)
@PLATFORMS
@FMI
@click.option("--no-arrays", is_flag=True, help="FMI 3.0 with a variable for each value, for hosts without arrays.")
@click.option(
    "--sources",
    is_flag=True,
    help="Native FMUs that hold their C code too, which any C99 compiler builds, for other targets.",
)
def build(
    output: Path, flavour: Flavour, assembled: str | None, scenario: str | None, no_arrays: bool, **options: Any
) -> None:
    """Build the FMUs into a folder.

    Those of flavour native run in any process. Those of flavour python need Python with NumPy in the process that
    imports them, or on the machine as a shared library."""
    import amb_cosim

    options |= {"flavour": flavour, "arrays": not no_arrays}
    with refusing():
        if assembled is not None and scenario is not None:
            raise ValueError("--assembled and --scenario exclude each other: --assembled SCENARIO is one FMU of all")
        check_writable(output, is_folder=True)
        if assembled is not None:
            whole = None if assembled == SYSTEM else assembled
            click.echo(amb_cosim.build_assembled(output, whole, **options))
            return
        for path in amb_cosim.build(output, scenario=scenario, **options):
            click.echo(path)
    if flavour == "python":
        from fmi_export.building.python_fmu import what_it_needs

        click.echo(what_it_needs(), err=True)


COMMANDS = (build,)
