"""The command `controller show`."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.controller import FILE, controller
from amb_cosim.commands.options import JSON, ROTOR, SPEED, UNITS, output
from amb_cosim.commands.printing import check_picture, print_result, warn_of_sizes

MODES = 8  # of the rotor, the lowest


@controller.command("show")
@FILE
@output("Bode plots to write: .png, .pdf or .svg.")
@ROTOR
@click.option("--speed", type=SPEED, default="0 rpm", help="Speed at which the law and the modes are evaluated.")
@JSON
@UNITS
def show(file: Path, output: Path | None, rotor: str | None, speed: str, as_json: bool) -> None:
    """Print a sampled controller and draw its Bode plots.

    With --rotor, the command prints the phase at each mode of the rotor on its bearings. A mode in which sensor and
    bearing move in phase is damped by the demand if this phase is between -180 and 0 degrees."""
    from amb_analysis import studies
    from amb_analysis.studies.controller_description import describe_controller
    from amb_cosim.presentation.progress import working

    with refusing(), working():
        if output is not None:
            check_picture(output)
        result = describe_controller(file, speed, _modes(rotor, speed))
        if output is not None:
            from amb_cosim.presentation.style import write_figure

            write_figure(studies.figure(result), output)
    print_result(result, as_json)


def _modes(rotor: str | None, speed: str) -> tuple[float, ...]:
    """Return the damped natural frequencies (rad/s) of a rotor at a speed, or none if `rotor` is None."""
    if rotor is None:
        return ()
    from amb_cosim.cosim.system.values import quantity
    from rotor_analysis.modes import modes
    from rotor_analysis.rotor_file import load_rotor
    from rotor_analysis.supported_rotor import supported_rotor

    warn_of_sizes(rotor)
    description = load_rotor(rotor)
    model = supported_rotor(description, description.shaft.mass_matrix).model
    return tuple(mode.frequency for mode in modes(model, quantity(speed, "rad/s", "speed"))[:MODES])
