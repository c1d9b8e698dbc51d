"""Command line: `amb-cosim`. What its commands do is in `commands`."""

from __future__ import annotations

import click

from orchestrator.commands import analysis, bench, build, identify, run


@click.group()
@click.version_option(package_name="amb-cosim")
def main() -> None:
    """Co-simulation of a flexible rotor in magnetic bearings that can touch its retainer bearings."""


for command in (*run.COMMANDS, *build.COMMANDS, *identify.COMMANDS, *analysis.COMMANDS, *bench.COMMANDS):
    main.add_command(command)
