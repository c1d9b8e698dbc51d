"""Command that draws or exports variables of a saved run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import UNITS, output
from amb_files.atomic import check_writable

if TYPE_CHECKING:
    from amb_cosim.results.result import Result

PICTURES = (".png", ".pdf", ".svg")
TABLES = (".csv", ".mat")


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.argument("variables", nargs=-1, required=True, metavar="VARIABLE...")
@output("File .png, .pdf, .svg, .csv or .mat; default traces.png in the result's folder.")
@click.option("--begin", metavar="MOMENT", help="First moment, 0.3 (s) or 'cycle 5'.")
@click.option("--until", metavar="MOMENT", help="Last moment.")
@UNITS
def plot(result: Path, variables: tuple[str, ...], output: Path | None, begin: str | None, until: str | None) -> None:
    """Draw variables of a saved run over time, or export them.

    A VARIABLE is a name with or without its component, or a pattern: left.x, '*.f_n'. The name of a figure draws that:
    orbits, turns, contact, .... The suffix of the output defines the format.
    """
    from amb_cosim.results.result import Result

    with refusing():
        run = Result.load(result)
        path = output or (result if result.is_dir() else result.parent) / f"{_figure(variables) or 'traces'}.png"
        if path.suffix.lower() not in PICTURES + TABLES:
            raise ValueError(f"{path} is not allowed; its name must end with {', '.join(PICTURES + TABLES)}")
        check_writable(path, is_folder=False)
        if path.suffix.lower() == ".csv":
            run.to_csv(path, *variables, begin=begin, until=until)
        elif path.suffix.lower() == ".mat":
            run.to_mat(path, *variables, begin=begin, until=until)
        else:
            _draw(run, path, variables, begin, until)
    click.echo(f"{'table' if path.suffix.lower() in TABLES else 'figure'} in {path}")


def _figure(variables: tuple[str, ...]) -> str | None:
    """Return the name of a figure that is called for in place of variables."""
    from amb_cosim.results.plots import MODULES

    return variables[0] if len(variables) == 1 and variables[0] in MODULES else None


def _draw(run: Result, path: Path, variables: tuple[str, ...], begin: str | None, until: str | None) -> None:
    from amb_cosim.presentation.style import write_figure
    from amb_cosim.results.plots import figure

    name = _figure(variables)
    if name and (begin or until):
        raise ValueError(f"--begin and --until cannot be used with the figure {name}; they are for variables")
    write_figure(figure(run.signals, name) if name else run.plot(*variables, begin=begin, until=until), path)


COMMANDS = (plot,)
