"""Commands that analyse: modes and tables of a rotor, and studies that draw figures."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console

from amb_cosim.commands.cli_errors import check_writable, refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS
from amb_cosim.commands.printing import print_parts, show
from amb_cosim.progress import progress_bar

if TYPE_CHECKING:
    from rotor_analysis.assembly import MassModel

Option = Callable[[Callable[..., None]], Callable[..., None]]

MASS = click.option(
    "--mass", type=click.Choice(["diagonal", "consistent"]), default="diagonal", show_default=True, help="Mass matrix."
)
COUNT = click.option("--count", type=int, default=8, show_default=True, help="Number of modes, the lowest first.")
UP_TO = click.option("--up-to", default="628 rad/s", show_default=True, help="Highest spin speed; also in Hz.")


@click.command()
@ROTOR
@MASS
@click.option("--speeds", default="90,120,145", show_default=True, help="Spin speeds in rad/s, or with their unit.")
@COUNT
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def modes(rotor_file: Path | None, mass: MassModel, speeds: str, count: int, as_json: bool) -> None:
    """Print the damped natural frequencies, damping ratios and whirl directions of a rotor."""
    from amb_cosim.studies import modal

    with refusing():
        data = modal.modes_at(modal.read_rotor(rotor_file), mass, modal.speed_list(speeds), count)
    show(data, modal.as_text, as_json)


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def tables(as_json: bool) -> None:
    """Print the thesis's tables 3.1 to 3.4 and the bearing constants, computed from the models."""
    from amb_cosim.studies.tables import as_text, thesis_tables

    show(thesis_tables(), as_text, as_json)


@click.group()
def study() -> None:
    """Analyse a rotor, its bearings or its co-simulation: draw figures and write their data."""


def register(
    name: str,
    description: str,
    *options: Option,
    module: str = "amb_cosim.studies.rotor",
    any_rotor: bool = True,
    reports: bool = False,
) -> None:
    """Add a study to the command line.

    Its function is `name` in `module`, imported when the study runs. It takes the options by keyword, the rotor of a
    file as `rotor` unless the study is not one of `any_rotor`, and, if it `reports`, `progress`, which it calls with
    what is done and how much there is; it returns an `amb_cosim.studies.outcome.Outcome`.
    """

    def run(output: Path | None, **settings: Any) -> None:
        from amb_cosim.studies.modal import read_rotor

        folder = output or Path("results") / f"study_{name}"
        console = Console(stderr=True)
        shown = progress_bar() if reports else console.status("computing (a first run compiles the models)")
        with refusing(), shown as progress:
            check_writable(folder, is_folder=True)
            if reports:
                settings["progress"] = progress
            if any_rotor:
                settings["rotor"] = read_rotor(settings.pop("rotor_file"))
            compute: Any = getattr(importlib.import_module(module), name)
            outcome = compute(**settings)
            outcome.write(folder, name)
        print_parts([*outcome.printed, f"results in {folder}"])

    output = click.option(
        "-o", "--output", type=click.Path(path_type=Path), help=f"Folder for the results; default results/study_{name}."
    )
    decorated: Callable[..., None] = run
    every: tuple[Option, ...] = (*((ROTOR,) if any_rotor else ()), *options, output)
    for add_option in reversed(every):
        decorated = add_option(decorated)
    study.command(name, help=description)(decorated)


register("campbell", "Frequencies and damping ratios over speed, critical speeds (Figs 3.1, 3.6).", MASS, UP_TO, COUNT)
register(
    "modes",
    "Mode shapes with their orbits (Figs 3.2, 3.3).",
    MASS,
    click.option("--speed", default="90 rad/s", show_default=True, help="Spin speed; also in Hz."),
    COUNT,
)
register(
    "tables",
    "Frequencies by mesh, mass matrix and condensation (Tables 3.1 to 3.4).",
    UP_TO,
    click.option("--planes", help="Nodes to condense to, 1,4,11,13; the master planes of the rotor by default."),
)
register(
    "unbalance_response",
    "Amplitude and phase over speed under unbalance at a node (Fig. 3.7).",
    MASS,
    UP_TO,
    click.option("--unbalance", default="10 g.m", show_default=True, help="Unbalance."),
    click.option("--node", type=int, help="Its node; the first disc by default."),
    click.option("--clearance", default="0.75 mm", show_default=True, help="Radial clearance, drawn as a line."),
)


def register_loop(name: str, description: str, *options: Option) -> None:
    """Add a study of the levitated rig: its function is `name` in the module of that name."""
    register(name, description, *options, module=f"amb_cosim.studies.{name}", any_rotor=False)


register_loop("coupling", "Convergence of the co-simulation to the system as a whole, over the communication step.")
register_loop(
    "sensitivity",
    "Stability margin of the levitated rotor (ISO 14839-3), computed and measured in a co-simulation.",
    click.option("--speed", default="90 rad/s", show_default=True, help="Spin speed; also in Hz."),
    click.option("--amplifier", is_flag=True, help="Amplifiers with bandwidth and voltage limit."),
    click.option("--delay", is_flag=True, help="Currents come a sample later."),
    click.option("--sample-time", default="250 us", show_default=True, help="Sample time of the controller."),
    SETTINGS,
)
register_loop(
    "linearisation",
    "K_s and K_i off the centre, range of the linear law, load capacity, slew rate and bandwidth of an axis.",
    click.option("--bias-current", default="4.43 A", show_default=True, help="Bias current of the coils."),
    click.option("--static-current", default="1.14 A", show_default=True, help="Current that carries the static load."),
)

TO_50_HZ = click.option("--up-to", default="50 Hz", show_default=True, help="Highest speed; also in rad/s.")
LEVITATED = (
    TO_50_HZ,
    click.option("--k-b", default="1e6 N/m", show_default=True, help="Net stiffness of the closed bearings."),
    click.option("--c-b", default="5000 N.s/m", show_default=True, help="Damping of the closed bearings."),
)
RECEPTANCE_STUDIES = "amb_cosim.studies.receptances"

register(
    "receptance",
    "Synchronous response of the eight sensors to the bearing forces over speed (Fig. 5.1).",
    *LEVITATED,
    module=RECEPTANCE_STUDIES,
)
register(
    "test_force",
    "Test force of an identification and how long it takes, over speed (Fig. 5.2).",
    TO_50_HZ,
    module="amb_cosim.studies.excitation",
    any_rotor=False,
)
register(
    "h_matrix",
    "H of the synchronous control over speed, exact and interpolated in a table, condition number (Fig. 5.3).",
    *LEVITATED,
    module=RECEPTANCE_STUDIES,
)
register(
    "recovery",
    "Share of runs that PID, OLAC, notch, force rejection and ROLAC free of contact, over the unbalance (Fig. 5.6).",
    click.option(
        "--steps",
        default="8,12,16,20,24,28,32,36,40,44,48 g.m",
        show_default=True,
        help="Unbalances added on D1, before the factor of scenario fig5_6.",
    ),
    # A number that does not divide into quarter turns: the four axes would look the same to them.
    click.option("--instants", type=int, default=5, show_default=True, help="Instants of the step within a turn."),
    click.option("--alpha", default="7 1/s", show_default=True, help="Adaptation rate."),
    FLAVOUR,
    module="amb_cosim.studies.recovery",
    any_rotor=False,
    reports=True,
)

COMMANDS = (modes, tables, study)
