"""The command that writes a first design of a machine."""

from __future__ import annotations

import re
from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FLAVOUR
from amb_cosim.cosim.choices import Flavour


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--mass", prompt=True, help="Mass of the rotor, such as '60 kg'.")
@click.option("--length", prompt=True, help="Its length, such as '1.2 m'.")
@click.option("--speed", prompt=True, help="Its highest speed in operation, such as '12000 rpm'.")
@click.option("--bearings", metavar="'Z Z'", help="Positions of the two magnetic bearings, such as '0.2 m 1.0 m'.")
@FLAVOUR
def new(folder: Path, mass: str, length: str, speed: str, bearings: str | None, flavour: Flavour) -> None:
    """Write a first design of a machine into a new FOLDER: rotor, magnets, a controller that levitates it, scenarios.

    What is not given is asked for.
    """
    from amb_cosim.cosim.values import quantity
    from amb_cosim.starter.files import new_machine
    from amb_cosim.starter.sizing import machine_sizes

    with refusing():
        places = None if bearings is None else [quantity(z, "m", "bearings") for z in _positions(bearings)]
        if places is not None and len(places) != 2:
            raise ValueError(f"bearings = {bearings!r} is not allowed; it must be two positions, such as '0.2 m 1.0 m'")
        sizes = machine_sizes(
            quantity(mass, "kg", "mass"),
            quantity(length, "m", "length"),
            quantity(speed, "rad/s", "speed"),
            None if places is None else (places[0], places[1]),
        )
        made = new_machine(folder, sizes, flavour)
    for side, load, point in zip(("left", "right"), sizes.load, made.points, strict=True):
        click.echo(
            f"{side:5} bearing, each axis: {load:.4g} N of the weight by {point.static_current:.3g} A; "
            f"K_s {point.k_s:.4g} N/m, K_i {point.k_i:.4g} N/A"
        )
    gains = made.gains
    click.echo(
        f"levitates with K_b = {gains.k_b:.3g} N/m, C_b = {gains.c_b:.3g} N s/m: damping ratios "
        f"of {gains.in_range:.2g} and more within the range of speed, {gains.beyond:.2g} and more beyond"
    )
    click.echo(f"wrote {folder}; next: amb-cosim run {folder / 'landing.toml'}")


def _positions(text: str) -> list[str]:
    """Return the positions in a text such as '0.2m 1.0m', '0.2 m, 1.0 m' or '0.2 1.0'."""
    return re.sub(r"\s+(?=[A-Za-z])", "", text.replace(",", " ")).split()


COMMANDS = (new,)
