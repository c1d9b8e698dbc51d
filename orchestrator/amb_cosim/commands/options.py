"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.cosim.choices import FLAVOURS, LOOPS

ROTOR = click.option(
    "--rotor",
    "rotor_file",
    metavar="NAME|FILE",
    help="Rotor of a pack, or rotor file (TOML); the packs' default without.",
)
FLAVOUR = click.option(
    "--flavour",
    type=click.Choice(FLAVOURS),
    default="native",
    show_default=True,
    help="Compiled FMUs that need no Python, or ones that PythonFMU runs, in a process that has Python.",
)
RECEPTANCES = click.option(
    "--receptances",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Table of receptances (TOML), as identify writes it, for the controller's H; the rotor model's H by default.",
)
SETTINGS = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="COMPONENT.VARIABLE=VALUE",
    help="Replace a value; units are understood.",
)
ISOLATED = click.option(
    "--isolated/--no-isolated",
    default=None,
    help="Whether FMUs run in a process of their own, so that a crash is a message; default for files.",
)
LOOP = click.option(
    "--loop",
    type=click.Choice(LOOPS),
    default="compiled",
    show_default=True,
    help="What calls the FMUs step by step: machine code, or Python, for reference.",
)
