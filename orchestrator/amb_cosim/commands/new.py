"""The command that writes a first design of a machine."""

from __future__ import annotations

import re
from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR, SPEED
from amb_cosim.cosim.basics.choices import Flavour


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--rotor", metavar="NAME|FILE", help="Rotor file of the drawing (TOML), or a rotor of a pack.")
@click.option("--mass", help="Mass of the rotor, such as '60 kg', where there is no drawing yet.")
@click.option("--length", help="Its length, such as '1.2 m'.")
@click.option("--speed", type=SPEED, prompt=True, help="Its highest speed in operation, such as '12000 rpm'.")
@click.option(
    "--bearings",
    metavar="'Z Z'",
    help="Positions of the two magnetic bearings, such as '0.2 m 1.0 m', unless the rotor file has its own.",
)
@FLAVOUR
def new(
    folder: Path,
    rotor: str | None,
    mass: str | None,
    length: str | None,
    speed: str,
    bearings: str | None,
    flavour: Flavour,
) -> None:
    """Write a first design of a machine into a new FOLDER.

    The folder has rotor, magnets, a controller that levitates the rotor, and scenarios.

    The rotor is that of a file, or a plain shaft of a mass and a length. What is not given is asked for.
    """
    from amb_cosim.cosim.system.values import quantity
    from amb_cosim.new_machine.files import new_machine
    from amb_cosim.new_machine.levitation import WANTED_BEYOND, WANTED_IN_RANGE

    with refusing():
        Omega = quantity(speed, "rad/s", "speed")
        text = _rotor_text(folder.name, rotor, mass, length, Omega)
        places = None if bearings is None else [quantity(z, "m", "bearings") for z in _positions(bearings)]
        if places is not None and len(places) != 2:
            raise ValueError(f"bearings = {bearings!r} is not allowed; it must be two positions, such as '0.2 m 1.0 m'")
        made = new_machine(folder, text, Omega, None if places is None else (places[0], places[1]), flavour)
    for bearing, point in made.points.items():
        click.echo(
            f"bearing {bearing}, each axis: {made.sizes.loads[bearing]:.4g} N of the weight by "
            f"{point.static_current:.3g} A; K_s {point.k_s:.4g} N/m, K_i {point.k_i:.4g} N/A"
        )
        if bearing not in {site.bearing for site in made.sizes.retainers}:
            click.echo(
                f"bearing {bearing} has no retainer; were it passive, its place is under [[seals]] of the rotor file"
            )
    if "bearings" in made.assumed:
        click.echo("retainers and sensors stand beside the bearings; move them in rotor.toml where they are elsewhere")
    if "damping" in made.assumed:
        click.echo("damping of the bending modes is assumed, 0.3, 0.5, then 1 %; put what you measure into rotor.toml")
    gains = made.gains
    click.echo(
        f"levitates with K_b = {gains.k_b:.3g} N/m, C_b = {gains.c_b:.3g} N s/m: damping ratios are at least "
        f"{gains.in_range:.3g} within the range of speed ({WANTED_IN_RANGE:g} is wanted) and {gains.beyond:.3g} beyond "
        f"({WANTED_BEYOND:g}); nearest to what is wanted is {gains.least_damped}"
    )
    click.echo(f"wrote {folder}; next: amb-cosim run {folder / 'landing.toml'}")


def _rotor_text(name: str, rotor: str | None, mass: str | None, length: str | None, Omega: float) -> str:
    """Return the text of the rotor file that is named, or of a plain shaft."""
    from amb_cosim.cosim.system.values import quantity
    from amb_cosim.new_machine.rotor_text import plain_shaft
    from amb_files.toml import read_text
    from rotor_analysis.packaged_rotors import rotor_path
    from rotor_analysis.rotor_file import load_rotor

    if rotor is None:
        m = quantity(mass or click.prompt("Mass"), "kg", "mass")
        return plain_shaft(name, m, quantity(length or click.prompt("Length"), "m", "length"), Omega)
    for key, values in (("mass", mass), ("length", length)):
        if values is not None:
            raise ValueError(f"{key} = {values!r} is given, but the rotor file has its own; give one of them")
    path = rotor_path(rotor)
    load_rotor(path)  # what is wrong with it names this file
    return read_text(path, f"rotor file {path}")


def _positions(text: str) -> list[str]:
    """Return the positions in a text such as '0.2m 1.0m', '0.2 m, 1.0 m' or '0.2 1.0'."""
    return re.sub(r"\s+(?=[A-Za-z])", "", text.replace(",", " ")).split()


COMMANDS = (new,)
