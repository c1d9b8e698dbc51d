"""The commands `study` and `linearise`, and the function with which packs add studies."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from amb_analysis import studies
from amb_cosim.commands.cli_errors import Refused, refusing, with_options
from amb_cosim.commands.options import (
    CURRENT,
    DAMPING,
    FLAVOUR,
    FREQUENCY,
    ROTOR,
    SETTINGS,
    SPEED,
    STIFFNESS,
    TIME,
    UNBALANCE,
    UNITS,
    Option,
    WithUnit,
    output,
)
from amb_cosim.commands.packs import GENERAL, PACKAGES, PackCommands
from amb_cosim.commands.printing import warn_of_sizes
from amb_files.atomic import check_writable

if TYPE_CHECKING:
    from amb_analysis.studies.result import DrawnResult


def _by_name(_: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    pairs = [text.partition("=") for text in texts]
    with refusing():
        for name, sign, value in pairs:
            if not (name and sign and value):
                raise ValueError(f"{option.opts[0]} {name + sign + value} is not allowed; it must be {option.metavar}")
        values: dict[str, str] = {}
        for name, value in ((name.strip(), value.strip()) for name, _, value in pairs):
            if values.setdefault(name, value) != value:
                raise ValueError(
                    f"{option.opts[0]} {name}={value} is not allowed with {name}={values[name]}; keep one of them"
                )
    return values


MASS = click.option(
    "--mass", type=click.Choice(["diagonal", "consistent"]), help="Mass matrix; default: as in the rotor file."
)
SCENARIO = click.argument("scenario", required=False)
COUNT = click.option("--count", type=int, default=8, show_default=True, help="Number of modes, lowest first.")
UP_TO_50_HZ = click.option("--up-to", type=SPEED, default="50 Hz", show_default=True, help="Highest speed.")
CONTROLLER = click.option(
    "--controller", metavar="FILE", help="Controller file (TOML, .npz, .mat) or FMU to use instead."
)
MACHINE, RUN = (SCENARIO, ROTOR, CONTROLLER), (SETTINGS, FLAVOUR)
CLOSED_BEARINGS = (
    click.option("--k-b", type=STIFFNESS, default="1e6 N/m", show_default=True, help="Net stiffness of the bearings."),
    click.option("--c-b", type=DAMPING, default="5000 N.s/m", show_default=True, help="Damping of the bearings."),
)
MEASURED = (
    click.option("--measured", metavar="FILE", help="Measurement: .uff, .mat, .npz, .csv, or a result."),
    click.option(
        "--loop",
        type=click.Choice(["free", "linear", "open", "closed"]),
        help="Support of the rotor; default: closed, or free with --rotor.",
    ),
    click.option("--input", "inputs", multiple=True, metavar="CHANNEL", help="Input, such as fan.f_x; repeatable."),
    click.option("--response", "outputs", multiple=True, metavar="CHANNEL", help="Output, such as eye.x; repeatable."),
    click.option(
        "--channel",
        "channels",
        multiple=True,
        callback=_by_name,
        metavar="NAME=PLACE",
        help="Place of a measured channel: acc1='0.12 m.x'.",
    ),
    click.option(
        "--channel-unit",
        "channel_units",
        multiple=True,
        callback=_by_name,
        metavar="NAME=UNIT",
        help="Unit of a measured channel or column: acc1=g.",
    ),
    click.option("--estimator", type=click.Choice(["H1", "H2"]), default="H1", show_default=True, help="Estimator."),
    click.option("--segment", help="Length of a segment; default: a blow, or 1/8 of the record."),
    click.option("--window", help="Window of a segment; default: as the record requires."),
    click.option("--exponential-window", metavar="TAU", help="Time constant of the records' exponential window: 0.2s."),
)


@click.group(cls=PackCommands)
def study() -> None:
    """Analyse a machine: draw figures and write data."""


study.list_in_section("Rotor", "campbell", "modes", "unbalance_response")
study.list_in_section("Bearings and control", "linearisation", "receptance", "response", "fit", "sensitivity", "poles")
study.list_in_section("Contact", "traps", "waterfall")
study.list_in_section("Checks of a result", "convergence", "coupling")


class RotorStudy(click.Command):
    """A command for a study of a rotor alone; if given a scenario, it recommends the study of the levitated machine."""

    levitated = "poles"

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse options, and refuse other arguments."""
        ctx.allow_extra_args = True
        rest = super().parse_args(ctx, args)
        if rest:
            machine = f"'amb-cosim study {self.levitated} {rest[0]}' for the levitated machine"
            raise Refused(f"study {self.name} takes no scenario; use {machine}, or --rotor NAME for a rotor")
        return rest


class ResponseOfRotor(RotorStudy):
    """A command for the study of the responses of a rotor alone."""

    levitated = "response"


def add_study(
    name: str, *options: Option, shows_progress: bool = False, cls: type[click.Command] = click.Command
) -> None:
    """Add a study of `amb_analysis.studies.STUDIES` to the command line; packs do this in their `commands` modules.

    Parameters
    ----------
    name
        Name of the study; its function is imported when the command runs.
    options
        Options of the command, whose values are passed to the study as keyword arguments.
    shows_progress
        Whether the study shows its own progress bar.
    cls
        Class of the command.
    """

    entry = studies.study_of(name)
    assert entry is not None

    def run(output: Path | None, **values: Any) -> None:
        from amb_cosim.presentation.progress import working
        from amb_cosim.presentation.text_tables import print_parts

        folder = output or Path("results") / f"study_{name}"
        with refusing():
            check_writable(folder, is_folder=True, files=(f"{name}.json", f"{name}.png"))
            warned = warn_of_sizes(values.get("rotor"))
        with refusing(), nullcontext() if shows_progress else working():
            compute: Callable[..., DrawnResult] = getattr(studies, name)
            result = compute(**values)
            studies.save(result, folder)
        told = [f"warning: {sentence}" for sentence in warned]
        parts = (part for part in result.text() if part not in told)
        print_parts(with_options(part) if isinstance(part, str) else part for part in parts)
        click.echo(f"results in {folder}")

    decorated: Callable[..., None] = run
    always: tuple[Option, ...] = (output(f"Folder for the results; default results/study_{name}."), UNITS)
    for add_option in (*always, *reversed(options)):
        decorated = add_option(decorated)
    added = study.command(name, cls=cls, help=entry.description)(decorated)
    PACKAGES[added] = entry.module.partition(".")[0] or GENERAL


add_study(
    "campbell",
    ROTOR,
    MASS,
    click.option("--up-to", type=SPEED, help="Highest speed; default: 1.25 x --speed, or the rotor's."),
    COUNT,
    click.option("--speed", type=SPEED, help="Speed of the machine, marked in the figure."),
    click.option("--full", is_flag=True, help="Analyse the full model, not the smallest sufficient one."),
    cls=RotorStudy,
)
add_study(
    "modes",
    ROTOR,
    MASS,
    click.option(
        "--speeds",
        type=SPEED,
        default="0",
        show_default=True,
        help="Spin speeds; mode shapes are drawn at the first speed.",
    ),
    COUNT,
    cls=RotorStudy,
)
add_study(
    "unbalance_response",
    *MACHINE,
    MASS,
    click.option("--up-to", type=SPEED, help="Highest speed; default: twice the scenario's, or the rotor's."),
    click.option("--unbalance", type=UNBALANCE, help="Unbalance; default: the scenario's, or grade G 2.5."),
    click.option("--place", metavar="PART", help="Place of the unbalance; default: the first disc."),
    click.option("--node", type=int, help="Node of the unbalance, instead of --place."),
    click.option(
        "--clearance", type=WithUnit("0.25 mm"), help="Radial clearance everywhere; default: each site's own."
    ),
    *RUN,
)
add_study("coupling", SCENARIO, ROTOR, *RUN)
add_study(
    "convergence",
    SCENARIO,
    ROTOR,
    SETTINGS,
    click.option(
        "--starts",
        type=int,
        default=4,
        show_default=True,
        help="Number of runs, whose clearances differ by 1e-6 of their size; use 50 if the motion is chaotic.",
    ),
    FLAVOUR,
    shows_progress=True,
)
add_study(
    "sensitivity",
    *MACHINE,
    click.option("--speed", type=SPEED, help="Spin speed; default: that of the scenario."),
    click.option("--amplifier", is_flag=True, help="Amplifiers with bandwidth and voltage limit."),
    click.option("--delay", is_flag=True, help="Delay currents by one sample."),
    click.option("--sample-time", type=TIME, help="Sample time of the controller; default: the scenario's."),
    *RUN,
)
add_study(
    "poles",
    *MACHINE,
    click.option("--up-to", type=SPEED, help="Highest spin speed; default: 1.5 times the scenario's."),
    COUNT,
    *RUN,
)
add_study(
    "traps",
    *MACHINE,
    click.option("--speed", type=SPEED, help="Spin speed of the machine; default: the scenario's."),
    click.option("--unbalance", type=UNBALANCE, help="Unbalance of the machine; default: the scenario's final one."),
    click.option("--place", metavar="DISC", help="Place of the unbalance; default: as in the scenario."),
    click.option("--up-to", type=SPEED, help="Highest speed of the map; default: twice the machine's."),
    click.option("--unbalance-up-to", type=UNBALANCE, help="Largest unbalance of the map; default: enough for a trap."),
    *RUN,
)
add_study(
    "linearisation",
    SCENARIO,
    ROTOR,
    click.option("--axis", metavar="BEARING.x|y|z", help="Axis; default: the first."),
    click.option("--bias-current", type=CURRENT, help="Bias current of the coils; default: that of the axis."),
    click.option("--static-current", type=CURRENT, help="Upper less lower coils, for the load; default: the axis's."),
    SETTINGS,
)
add_study("receptance", ROTOR, UP_TO_50_HZ, *CLOSED_BEARINGS, cls=ResponseOfRotor)
add_study(
    "response",
    *MACHINE,
    *MEASURED,
    click.option("--speed", type=SPEED, help="Spin speed; default: the scenario's, 0 for a rotor."),
    click.option("--from", "lowest", type=FREQUENCY, help="Lowest frequency; default: as measured, or 1 Hz."),
    click.option("--up-to", type=FREQUENCY, help="Highest frequency; default: as measured, or 1 kHz."),
    *RUN,
)
add_study(
    "fit",
    *MACHINE,
    *MEASURED,
    click.option(
        "--free", multiple=True, metavar="NAME=LO:HI", help="Parameter with bounds: bodies.fan.mass=3:5; repeatable."
    ),
    click.option("--speed", type=SPEED, help="Spin speed; default: the scenario's, 0 for a rotor."),
    click.option("--from", "lowest", type=FREQUENCY, help="Lowest frequency; default: as measured."),
    click.option("--up-to", type=FREQUENCY, help="Highest frequency; default: as measured."),
    *RUN,
)
add_study(
    "waterfall",
    click.argument("source", required=False),
    click.option("--up-to", type=SPEED, help="Highest frequency; default: 2.5 times the highest spin frequency."),
    click.option("--window", help="Length of a window; default: 1 s, or an eighth of the run."),
    ROTOR,
    *RUN,
    shows_progress=True,
)


@click.command()
@SCENARIO
@ROTOR
@CONTROLLER
@click.option("--at", type=SPEED, help="Spin speed; default: that of the scenario.")
@click.option(
    "--input", "inputs", multiple=True, metavar="PATTERN", help="component.variable; default: unconnected inputs."
)
@click.option("--shown", "outputs", multiple=True, metavar="PATTERN", help="component.variable; default: all.")
@click.option("--component", "components", multiple=True, metavar="NAME", help="Components of the model; default: all.")
@click.option("--open", "opened", multiple=True, metavar="PATTERN", help="Inputs to disconnect.")
@SETTINGS
@FLAVOUR
@output("File to write, .mat or .npz.", "linear_model.mat")
def linearise(scenario: str | None, controller: str | None, output: Path, **options: Any) -> None:
    """Write the linear model of a machine or a part.

    The file contains the matrices A, B, C and D of the machine, of a part of it, or of its sampled loop, with the names
    and units of all signals.
    """
    from amb_analysis.linear import linearise as linear
    from amb_cosim.presentation.progress import working
    from amb_cosim.results.component_names import CONTROLLER as COMPONENT

    values: dict[str, Any] = {name: value or None for name, value in options.items() if name != "opened"}
    fmu = None if controller is None else {COMPONENT: controller}
    with refusing(), working():
        check_writable(output, is_folder=False)
        model = linear.linearise(scenario, opened=options["opened"], fmu=fmu, **values)
        path = model.save(output)
    sampled = f"sampled every {model.dt:g} s" if model.dt else "continuous"
    click.echo(f"{model.nstates} states, {model.ninputs} inputs, {model.noutputs} outputs, {sampled}; in {path}")
    for note in model.notes:
        click.echo(f"notice: {note}", err=True)
    for sentence in model.warnings:
        click.echo(f"warning: {sentence}", err=True)


study.add_examples(
    {
        "campbell": ("study campbell --rotor compressor --speed '9000 rpm'", "study campbell --rotor pump/rotor.toml"),
        "modes": ("study modes --rotor compressor", "study modes --rotor compressor --speeds '0,9000 rpm'"),
        "unbalance_response": (
            "study unbalance_response compressor_levitated",
            "study unbalance_response --rotor compressor --place impeller1",
        ),
        "coupling": ("study coupling compressor_levitated", "study coupling pump/levitation.toml"),
        "convergence": ("study convergence pump/landing.toml", "study convergence pump/landing.toml --starts 8"),
        "sensitivity": (
            "study sensitivity compressor_levitated",
            "study sensitivity pump/levitation.toml --speed '12000 rpm' --delay",
        ),
        "poles": (
            "study poles compressor_levitated",
            "study poles pump/levitation.toml --controller lead.npz",
        ),
        "traps": ("study traps pump/levitation.toml", "study traps pump/levitation.toml --unbalance '20 g.mm'"),
        "linearisation": ("study linearisation drop", "study linearisation pump/levitation.toml --bias-current '4 A'"),
        "receptance": ("study receptance --rotor compressor", "study receptance --rotor compressor --up-to '150 Hz'"),
        "response": (
            "study response pump/run.toml --input fan.f_x --response eye.x",
            "study response --rotor pump/rotor.toml --measured impact.csv",
        ),
        "fit": (
            "study fit --rotor x.toml --measured x.csv --free bodies.a.mass=3:5",
            "study fit --rotor x.toml --measured x.uff --free bodies.a.mass=3:5",
        ),
        "waterfall": ("study waterfall results/drop", "study waterfall compressor_levitated --up-to '500 Hz'"),
    }
)
