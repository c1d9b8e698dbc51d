"""Commands that build FMUs, write SSP archives and check FMUs against their reference results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, FMI, PLATFORMS, RECEPTANCES, ROTOR, SETTINGS, UNTIL, output
from amb_cosim.commands.printing import compilations_shown, warn_of_sizes
from amb_files.atomic import check_writable

SYSTEM = "levitated"  # assembled if no scenario is named


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
    help="Build one FMU of all components of a scenario or, by default, of the system `levitated`.",
)
@click.option("--scenario", metavar="SCENARIO", help="Use a scenario's values as start values.")
@click.option(
    "--controller",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Build only linear_controller.fmu, with this file's law.",
)
@PLATFORMS
@FMI
@click.option("--no-arrays", is_flag=True, help="Build FMI 3.0 FMUs without arrays, one variable per value.")
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

    FMUs of flavour native run in any process. FMUs of flavour python need Python with NumPy: in the process that
    imports them, or as a shared library on the machine.

    With --assembled, one FMU contains rotor, actuator and controller of a scenario (name or TOML file), or all
    components of a system file, and steps them together. With --scenario, the FMUs of the components have the
    scenario's parameters and initial inputs as start values. This is useful for masters that you wire by hand.

    Platforms are linux64 and win64. Native FMUs can also be built for darwin64, aarch64-linux, aarch64-darwin, and
    wasm32 (WebAssembly for browsers); the choice all does not include wasm32.
    """
    from amb_cosim.controllers.linear_controller import linear_controller
    from amb_cosim.export.assembled import build_assembled
    from amb_cosim.export.build import build as build_fmus

    options["arrays"] = not no_arrays
    with refusing(), compilations_shown():
        if assembled is not None and scenario is not None:
            raise ValueError("--assembled and --scenario cannot be combined; use --assembled SCENARIO")
        check_writable(output, is_folder=True)
        if controller is not None:
            unused = [options.pop(name) for name in ("rotor", "receptances", "sources")]
            if assembled or scenario or any(unused) or not options.pop("arrays"):
                allowed = "--flavour, --platforms, --fmi and --output"
                raise ValueError(f"--controller {controller} can only be combined with {allowed}")
            click.echo(linear_controller(controller).build(output, **options))
            return
        warn_of_sizes(options["rotor"])
        if assembled is not None:
            click.echo(build_assembled(output, assembled, **options))
            return
        for path in build_fmus(output, scenario=scenario, **options):
            click.echo(path)
        if options["rotor"] is not None and scenario is None:
            click.echo(
                f"notice: only the rotor is from {options['rotor']}; magnets, controller and gravity have default "
                "start values, which may suit another machine. Use --scenario for the values of yours",
                err=True,
            )
    if options["flavour"] == "python":
        from fmi_export.building.python_fmu import what_it_needs

        click.echo(what_it_needs(), err=True)


@click.command("export-ssp")
@click.argument("name")
@SETTINGS
@output("Archive to write; default: NAME.ssp.")
@UNTIL
@ROTOR
@RECEPTANCES
@FLAVOUR
@PLATFORMS
@click.option("--connectors", is_flag=True, help="Add system connectors for inputs; libcosim refuses them.")
@click.option("--integers", is_flag=True, help="Describe Enumerations as Integers, for libcosim and ecos.")
def export_ssp(name: str, output: Path | None, **options: Any) -> None:
    """Write a scenario with its FMUs as an SSP archive.

    NAME is a scenario or its TOML file. The archive is SSP 1.0, for other tools.
    """
    from amb_cosim.export import exchange

    path = output or Path(f"{Path(name).stem}.ssp")
    with refusing(), compilations_shown():
        check_writable(path, is_folder=False)
        exchange.export_ssp(name, path, **options)
    click.echo(path)


@click.command()
@click.argument("fmu", type=click.Path(path_type=Path))
@click.pass_context
def verify(ctx: click.Context, fmu: Path) -> None:
    """Check an FMU against its reference results.

    FMPy runs the experiments in the FMU (FMI-LS-REF).

    The exit code is 1 if a value differs or an experiment cannot be run.
    """
    from amb_cosim.cosim.verify.verification import verify

    with refusing():
        results = verify(fmu)
    for result in results:
        click.echo(result)
    if not all(result.is_equal for result in results):
        ctx.exit(1)


COMMANDS = (build, export_ssp, verify)
