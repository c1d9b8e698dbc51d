"""The command that builds the FMUs."""

from __future__ import annotations

from pathlib import Path

import click

from orchestrator.commands.refusals import check_writable, refusing


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("build"), show_default=True)
@click.option(
    "--rotor",
    "rotor_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Rotor file (TOML); the rig of the thesis by default.",
)
def build(output: Path, rotor_file: Path | None) -> None:
    """Build the FMUs into a folder."""
    from orchestrator.build import build_all

    with refusing():
        check_writable(output, is_folder=True)
        for path in build_all(output, rotor_file):
            click.echo(path)


COMMANDS = (build,)
