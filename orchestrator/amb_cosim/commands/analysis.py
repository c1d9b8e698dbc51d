"""Commands that analyse: modes of a rotor, and studies that draw figures."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from amb_cosim import studies
from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS, SPEED, UNITS, Option, output
from amb_cosim.commands.packs import OWN_PACKAGE, PACKAGES, PackCommands
from amb_files.atomic import check_writable

if TYPE_CHECKING:
    from amb_cosim.studies.result import DrawnResult

MASS = click.option(
    "--mass", type=click.Choice(["diagonal", "consistent"]), help="Mass matrix; by default as the rotor file says."
)
SCENARIO = click.argument("scenario", required=False)
COUNT = click.option("--count", type=int, default=8, show_default=True, help="Number of modes, the lowest first.")
UP_TO = click.option("--up-to", type=SPEED, default="628 rad/s", show_default=True, help="Highest spin speed.")
UP_TO_50_HZ = click.option("--up-to", type=SPEED, default="50 Hz", show_default=True, help="Highest speed.")
CONTROLLER = click.option(
    "--controller", metavar="FILE", help="Controller file (TOML, .npz, .mat) or FMU in place of the scenario's."
)
CLOSED_BEARINGS = (
    click.option("--k-b", default="1e6 N/m", show_default=True, help="Net stiffness of the closed bearings."),
    click.option("--c-b", default="5000 N.s/m", show_default=True, help="Damping of the closed bearings."),
)


@click.group(cls=PackCommands)
def study() -> None:
    """Analyse a machine: draw figures and write data."""


study.sections = {
    "Rotor": ("campbell", "modes", "unbalance_response"),
    "Bearings and control": ("linearisation", "receptance", "sensitivity", "poles"),
    "Contact": ("traps", "waterfall"),
    "Is a result right?": ("robustness", "convergence", "coupling"),
}


def add_study(name: str, *options: Option, shows_progress: bool = False) -> None:
    """Add a study of `amb_cosim.studies.STUDIES` to the command line; modules `commands` of packs do so for theirs.

    Parameters
    ----------
    name
        Name of the study; its function is imported when the command runs.
    options
        Options of the command. Their values are passed by keyword.
    shows_progress
        Whether the study shows a progress bar of its own.
    """

    described = studies.study_of(name)
    assert described is not None

    def run(output: Path | None, **values: Any) -> None:
        from rich.console import Console

        from amb_cosim.presentation.text_tables import print_parts

        folder = output or Path("results") / f"study_{name}"
        status: AbstractContextManager[object] = nullcontext()
        if not shows_progress:
            status = Console(stderr=True).status("computing (a first run compiles the models)")
        with refusing(), status:
            check_writable(folder, is_folder=True)
            compute: Callable[..., DrawnResult] = getattr(studies, name)
            result = compute(**values)
            studies.save(result, folder)
        print_parts([*result.text(), f"results in {folder}"])

    decorated: Callable[..., None] = run
    always: tuple[Option, ...] = (output(f"Folder for the results; default results/study_{name}."), UNITS)
    for add_option in (*always, *reversed(options)):
        decorated = add_option(decorated)
    added = study.command(name, help=described.description)(decorated)
    PACKAGES[added] = described.module.partition(".")[0] or OWN_PACKAGE


add_study(
    "campbell",
    ROTOR,
    MASS,
    UP_TO,
    COUNT,
    click.option("--speed", type=SPEED, help="Speed of the machine, which the figure marks."),
    click.option("--full", is_flag=True, help="Analyse the full model, not the smallest one within 1e-5."),
)
add_study(
    "modes",
    ROTOR,
    MASS,
    click.option("--speeds", type=SPEED, default="0", show_default=True, help="Spin speeds; shapes are of the first."),
    COUNT,
)
add_study(
    "unbalance_response",
    ROTOR,
    MASS,
    UP_TO,
    click.option("--unbalance", default="10 g.m", show_default=True, help="Unbalance."),
    click.option("--node", type=int, help="Its node; the first disc by default."),
    click.option("--clearance", help="Radial clearance everywhere; that of the rotor's sites by default."),
)
add_study("coupling", SCENARIO, ROTOR, SETTINGS, FLAVOUR)
add_study(
    "convergence",
    SCENARIO,
    ROTOR,
    SETTINGS,
    click.option(
        "--starts", type=int, default=4, show_default=True, help="Runs whose clearances differ by 1e-6; 50 if chaotic."
    ),
    FLAVOUR,
    shows_progress=True,
)
add_study(
    "sensitivity",
    SCENARIO,
    ROTOR,
    CONTROLLER,
    click.option("--speed", type=SPEED, help="Spin speed; that of the scenario by default."),
    click.option("--amplifier", is_flag=True, help="Amplifiers with bandwidth and voltage limit."),
    click.option("--delay", is_flag=True, help="Delay currents by one sample."),
    click.option("--sample-time", help="Sample time of the controller; that of the scenario by default."),
    SETTINGS,
    FLAVOUR,
)
add_study(
    "poles",
    SCENARIO,
    ROTOR,
    CONTROLLER,
    click.option("--up-to", type=SPEED, help="Highest spin speed; 1.5 times that of the scenario by default."),
    COUNT,
    SETTINGS,
    FLAVOUR,
)
add_study(
    "traps",
    SCENARIO,
    ROTOR,
    CONTROLLER,
    click.option("--speed", type=SPEED, help="Spin speed of the machine; that of the scenario by default."),
    click.option("--unbalance", help="Its unbalance; that at the end of the scenario by default."),
    click.option("--place", metavar="DISC", help="Where the unbalance is; as in the scenario by default."),
    click.option("--up-to", type=SPEED, help="Highest spin speed of the map; twice that of the machine by default."),
    click.option("--unbalance-up-to", help="Largest unbalance of the map; by default beyond what traps."),
    SETTINGS,
    FLAVOUR,
)
add_study(
    "linearisation",
    SCENARIO,
    ROTOR,
    click.option("--axis", metavar="BEARING.x|y", help="Axis; the first one by default."),
    click.option("--bias-current", help="Bias current of the coils; that of the axis by default."),
    click.option("--static-current", help="Current that carries the static load; that of the axis by default."),
    SETTINGS,
)
add_study(
    "robustness",
    SCENARIO,
    ROTOR,
    SETTINGS,
    click.option("--change", type=float, default=0.01, show_default=True, help="Share more and less of each quantity."),
    FLAVOUR,
    shows_progress=True,
)
add_study("receptance", ROTOR, UP_TO_50_HZ, *CLOSED_BEARINGS)
add_study(
    "waterfall",
    click.argument("source", required=False),
    click.option("--up-to", type=SPEED, default="60 Hz", show_default=True, help="Highest frequency."),
    click.option("--window", help="Length of a window; 1 s, or an eighth of a shorter run, by default."),
    ROTOR,
    SETTINGS,
    FLAVOUR,
    shows_progress=True,
)


@click.command()
@SCENARIO
@ROTOR
@CONTROLLER
@click.option("--at", type=SPEED, help="Spin speed; that of the scenario by default.")
@click.option("--input", "inputs", multiple=True, metavar="PATTERN", help="component.variable; free ones by default.")
@click.option("--shown", "outputs", multiple=True, metavar="PATTERN", help="component.variable; all by default.")
@click.option("--component", "components", multiple=True, metavar="NAME", help="Of the model; all by default.")
@click.option("--open", "opened", multiple=True, metavar="PATTERN", help="Inputs whose connection is cut.")
@SETTINGS
@FLAVOUR
@output("File to write, .mat or .npz.", "linear_model.mat")
def linearise(scenario: str | None, controller: str | None, output: Path, **options: Any) -> None:
    """Write the linear model of a machine or a part.

    The file has A, B, C, D with names and units, of the machine, a part of it, or its sampled loop.
    """
    import amb_cosim
    from amb_cosim.results.places import CONTROLLER as COMPONENT

    values: dict[str, Any] = {name: value or None for name, value in options.items() if name != "opened"}
    fmu = None if controller is None else {COMPONENT: controller}
    with refusing():
        check_writable(output, is_folder=False)
        model = amb_cosim.linearise(scenario, opened=options["opened"], fmu=fmu, **values)
        path = model.save(output)
    sampled = f"sampled every {model.dt:g} s" if model.dt else "continuous"
    click.echo(f"{model.nstates} states, {model.ninputs} inputs, {model.noutputs} outputs, {sampled}; in {path}")
    for note in model.notes:
        click.echo(f"notice: {note}", err=True)


COMMANDS = (study, linearise)
