"""Command that writes an animation of a saved run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import output
from amb_files.atomic import check_writable


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@output("File, .gif or .mp4; default: orbits.gif with the result.")
@click.option("--begin", type=float, metavar="CYCLE", help="First cycle; default: that of the run.")
@click.option("--end", type=float, metavar="CYCLE", help="Last cycle; default: that of the run.")
@click.option("--frames-per-cycle", type=float, default=20.0, show_default=True, help="Frames per cycle.")
@click.option("--frames-per-second", type=int, default=25, show_default=True, help="Frames per second.")
@click.option("--trail", type=float, default=1.0, show_default=True, metavar="CYCLES", help="Length of the trail.")
def animate(result: Path, output: Path | None, **options: Any) -> None:
    """Write an animation of the orbits of a saved run.

    RESULT is the folder of the run or its file .nc.
    """
    import amb_cosim
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.results.animation import animate as write_animation

    with refusing(), plain_console(stderr=True).status("drawing"):
        matches = amb_cosim.Result.load(result)
        path = output or (result if result.is_dir() else result.parent) / "orbits.gif"
        check_writable(path, is_folder=False)
        write_animation(matches.signals, path, **options)
    click.echo(f"animation in {path}")


COMMANDS = (animate,)
