"""Command that draws or exports variables of a saved run."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import UNITS, output
from amb_cosim.commands.printing import check_picture
from amb_files.atomic import plain_file

TABLES = (".csv", ".mat")
MOVING, FILMS = "landing", (".gif", ".mp4")


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.argument("variables", nargs=-1, required=True, metavar="VARIABLE...")
@output(
    "Output file (.png, .pdf, .svg, .csv, .mat; landing: .gif, .mp4); default: FIGURE.png, traces.png or landing.gif "
    "in the result folder."
)
@click.option("--begin", metavar="MOMENT", help="Start time, such as 0.3 (s) or 'cycle 5'.")
@click.option("--until", metavar="MOMENT", help="Last moment.")
@UNITS
def plot(result: Path, variables: tuple[str, ...], output: Path | None, begin: str | None, until: str | None) -> None:
    """Draw variables of a saved run over time, or export them.

    A VARIABLE is a name with or without its component, or a pattern: left.x, '*.f_n'. The name of a figure (orbits,
    turns, contact, ...) draws that figure, and landing shows the first impacts in slow motion. The suffix of the output
    defines the format.
    """
    from amb_cosim.results.plots import MODULES, figure
    from amb_cosim.results.result import Result
    from amb_cosim.results.signal_arrays import finite_signals, not_finite

    name = variables[0] if len(variables) == 1 and variables[0] in MODULES else None
    with refusing():
        run = Result.load(result)
        if variables == (MOVING,):
            from amb_cosim.results.plots.landing import write_landing

            path = output or plain_file(result if result.is_dir() else result.parent, f"{MOVING}.gif")
            check_picture(path, FILMS, pictures=())
            write_landing(run.signals, path, begin, until)
            click.echo(f"animation in {path}")
            return
        path = output or plain_file(result if result.is_dir() else result.parent, f"{name or 'traces'}.png")
        suffix = path.suffix.lower()
        check_picture(path, TABLES)
        if suffix in TABLES:
            export = run.to_csv if suffix == ".csv" else run.to_mat
            export(path, *variables, begin=begin, until=until)
        else:
            from amb_cosim.presentation.style import write_figure

            if name and (begin or until):
                raise ValueError(
                    f"--begin and --until cannot be used with the figure {name}; they apply only to variables"
                )
            if name and (left_out := finite_signals(run.signals)[1]):
                click.echo(f"amb-cosim: {result}: some signals are not plotted: {not_finite(left_out)}", err=True)
            drawn = figure(run.signals, name) if name else run.plot(*variables, begin=begin, until=until)
            write_figure(drawn, path)
    click.echo(f"{'table' if suffix in TABLES else 'figure'} in {path}")


COMMANDS = (plot,)
