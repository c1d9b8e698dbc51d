"""The command that builds the FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, FMI, PLATFORMS, RECEPTANCES, ROTOR, output
from amb_files.atomic import check_writable

SYSTEM = "levitated"  # assembled without a scenario


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
    help="One FMU of all components; default: system levitated.",
)
@click.option(
    "--scenario",
    metavar="SCENARIO",
    help="Use a scenario's values as start values.",
)
@click.option(
    "--controller",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Only linear_controller.fmu, with the law of this file.",
)
@PLATFORMS
@FMI
@click.option("--no-arrays", is_flag=True, help="FMI 3.0 with one variable per value.")
@click.option("--sources", is_flag=True, help="Include the C code (C99) in native FMUs, for other targets.")
def build(
    output: Path,
    assembled: str | None,
    scenario: str | None,
    controller: Path | None,
    no_arrays: bool,
    **options: Any,
) -> None:
    """Build the FMUs into a folder.

    FMUs of flavour native run in any process. Those of flavour python need Python with NumPy in the importing process,
    or on the machine as a shared library.

    With --assembled, one FMU contains rotor, actuator and controller of a scenario (name or TOML file), or all
    components of a system file, and steps them together. With --scenario, the FMUs of the components have the
    scenario's parameters and initial inputs as start values, for masters wired by hand.

    Platforms are linux64 and win64, for native FMUs also darwin64, aarch64-linux, aarch64-darwin, and wasm32
    (WebAssembly for browsers), which all does not include.
    """
    from amb_cosim.export.assembled import build_assembled
    from amb_cosim.export.build import build as build_fmus

    options["arrays"] = not no_arrays
    with refusing():
        if assembled is not None and scenario is not None:
            raise ValueError("--assembled and --scenario exclude each other; use --assembled SCENARIO")
        check_writable(output, is_folder=True)
        if controller is not None:
            _build_controller(controller, output, assembled, scenario, **options)
            return
        if assembled is not None:
            whole = None if assembled == SYSTEM else assembled
            click.echo(build_assembled(output, whole, **options))
            return
        for path in build_fmus(output, scenario=scenario, **options):
            click.echo(path)
    if options["flavour"] == "python":
        from fmi_export.building.python_fmu import what_it_needs

        click.echo(what_it_needs(), err=True)


def _build_controller(
    file: Path,
    output: Path,
    *others: str | None,
    rotor: str | None,
    receptances: Path | None,
    arrays: bool,
    sources: bool,
    **options: Any,
) -> None:
    """Build the FMU of a controller file."""
    from amb_cosim.controllers.linear_controller import linear_controller

    if any((*others, rotor, receptances, not arrays, sources)):
        raise ValueError(f"--controller {file} can only be combined with --flavour, --platforms, --fmi and --output")
    click.echo(linear_controller(file).build(output, **options))


COMMANDS = (build,)
