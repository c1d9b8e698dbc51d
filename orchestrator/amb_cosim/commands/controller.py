"""Commands for controller files: show, import."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.former import Group
from amb_cosim.commands.options import JSON, ROTOR, SPEED, TIME, output
from amb_cosim.commands.printing import print_result
from amb_files.atomic import check_writable

FILE = click.argument("file", type=click.Path(path_type=Path))
DRAWN = 8  # modes of the rotor, the lowest
AT_SPEED = click.option("--speed", type=SPEED, default="0 rpm", help="Speed of the law and of the rotor's modes.")


@click.group(cls=Group, former={"build": "build --controller FILE"})
def controller() -> None:
    """Show or import a controller file.

    A controller file contains blocks (TOML) or arrays (.npz, .mat).
    """


@controller.command("show")
@FILE
@output("Bode plots to write.", metavar="PNG")
@ROTOR
@AT_SPEED
@JSON
def show(file: Path, output: Path | None, rotor: str | None, speed: str, as_json: bool) -> None:
    """Print a sampled controller and draw its Bode plots.

    With --rotor, the phase at each mode of the rotor on its bearings is printed: between -180 and 0 degrees the demand
    damps a mode in which sensor and bearing move alike."""
    from amb_cosim.controllers import bode
    from amb_cosim.controllers.show import description

    with refusing():
        if output is not None:
            check_writable(output, is_folder=False)
        result = description(file, speed, _modes(rotor, speed))
        if output is not None:
            from amb_cosim.presentation.style import write_png

            write_png(bode.draw(result.connections, result.omega, result.modes), output)
    print_result(result, as_json)


@controller.command("import")
@FILE
@output("Output, .npz or .mat; default: FILE_controller.npz.")
@click.option("--inputs", metavar="NAMES", help="Measured signals, with commas; default: the file's.")
@click.option("--outputs", metavar="NAMES", help="Demands, with commas; default: the file's.")
@click.option("--sample-time", type=TIME, metavar="TIME", help="Sample time for a continuous law, such as 100us.")
def import_arrays(
    file: Path, output: Path | None, inputs: str | None, outputs: str | None, sample_time: str | None
) -> None:
    """Make a controller file from arrays A, B, C, D.

    The arrays of FILE (.mat, .npz) are checked, sampled and named.
    """
    from amb_cosim.controllers.linear_controller import linear_controller
    from amb_cosim.cosim.system.tables import time_of

    signals, demands = (None if names is None else [n.strip() for n in names.split(",")] for names in (inputs, outputs))
    path = output or Path(f"{file.stem}_controller.npz")
    with refusing():
        check_writable(path, is_folder=False)
        time = None if sample_time is None else time_of(sample_time, "--sample-time")
        click.echo(linear_controller(file, signals, demands, time).save(path))


def _modes(rotor: str | None, speed: str) -> tuple[float, ...]:
    """Return the damped natural frequencies of a rotor at a speed (rad/s); none without a rotor."""
    if rotor is None:
        return ()
    from amb_cosim.cosim.system.values import quantity
    from rotor_analysis.modes import modes
    from rotor_analysis.rotor_file import load_rotor
    from rotor_analysis.supported_rotor import supported_rotor

    read = load_rotor(rotor)
    model = supported_rotor(read, read.shaft.mass_matrix).model
    return tuple(mode.frequency for mode in modes(model, quantity(speed, "rad/s", "speed"))[:DRAWN])


COMMANDS = (controller,)
