"""Command line: `amb-cosim`. What its commands do is in `commands`."""

from __future__ import annotations

import click

from amb_cosim.commands import analysis, build, export, identify, rotor, run


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="amb-cosim")
def main() -> None:
    """Co-simulation of a flexible rotor in magnetic bearings that can touch its retainer bearings."""


for command in (
    *run.COMMANDS,
    *build.COMMANDS,
    *export.COMMANDS,
    *identify.COMMANDS,
    *analysis.COMMANDS,
    *rotor.COMMANDS,
):
    main.add_command(command)
