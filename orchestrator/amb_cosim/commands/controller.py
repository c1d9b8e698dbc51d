"""The command group for controller files, and its command `import`."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import TIME, output
from amb_cosim.commands.packs import PackCommands
from amb_files.atomic import check_writable

FILE = click.argument("file", type=click.Path(path_type=Path))


@click.group(cls=PackCommands)
def controller() -> None:
    """Show or import a controller file.

    A controller file contains blocks (TOML) or arrays (.npz, .mat).
    """


@controller.command("import")
@FILE
@output("Output, .npz or .mat; default: FILE_controller.npz.")
@click.option("--inputs", metavar="NAMES", help="Measured signals, comma-separated; default: the file's.")
@click.option("--outputs", metavar="NAMES", help="Demands, comma-separated; default: the file's.")
@click.option("--sample-time", type=TIME, metavar="TIME", help="Sample time, such as 100us, for a continuous law.")
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


COMMANDS = (controller,)
