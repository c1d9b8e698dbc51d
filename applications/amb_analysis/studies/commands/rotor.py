"""The command `rotor show`."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import JSON, UNITS, output
from amb_cosim.commands.printing import check_picture, print_result
from amb_cosim.commands.rotor import rotor


@rotor.command("show")
@click.argument("name")
@output("Picture to write: .png, .pdf or .svg.")
@JSON
@UNITS
def show(name: str, output: Path | None, as_json: bool) -> None:
    """Show and draw parts, mass and modes of a rotor.

    NAME is a packaged rotor or a rotor file. The command also describes the plant's model of the rotor.
    """
    from amb_analysis import studies
    from amb_cosim.presentation.progress import working
    from rotor_analysis.packaged_rotors import rotor_path
    from rotor_analysis.rotor_file import load_rotor

    with refusing(), working():
        if output is not None:
            check_picture(output)
        load_rotor(name)  # its errors name the file
        try:
            result = studies.layout(name)
        except ValueError as error:
            raise ValueError(f"rotor file {rotor_path(name)}: {error}") from error
        if output is not None:
            from amb_cosim.presentation.style import write_figure

            write_figure(studies.figure(result), output)
    print_result(result, as_json)
