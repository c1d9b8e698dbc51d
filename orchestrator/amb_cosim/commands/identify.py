"""The command that identifies the receptances of the levitated rotor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.console import Console

from amb_cosim import studies
from amb_cosim.commands.cli_errors import Failed, check_writable, refusing
from amb_cosim.commands.options import FLAVOUR, ROTOR, SETTINGS
from amb_cosim.cosim.fmus import Flavour
from amb_cosim.progress import STARTING, bars
from amb_cosim.text_tables import print_parts

if TYPE_CHECKING:
    from amb_cosim.studies.receptance_identification import IdentificationProgress


@click.command()
@click.option(
    "--speeds",
    metavar="LIST",
    help="Spin speeds with commas, each in rad/s or with its unit (5 Hz,10 Hz); the thesis's twelve by default.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default="receptances.toml",
    show_default=True,
    help="Table of receptances; what it holds of other speeds stays.",
)
@ROTOR
@SETTINGS
@FLAVOUR
def identify(
    speeds: str | None, output: Path, rotor_file: Path | None, settings: tuple[str, ...], flavour: Flavour
) -> None:
    """Identify the receptances of the levitated rotor, as its controller does, and keep them in a table.

    Give the table to `run` or `build` with --receptances. It is written after each speed.
    """
    from amb_cosim.plan import parse_settings

    with refusing(), _progress_bars(Console(stderr=True)) as progress:
        check_writable(output, is_folder=False)
        result = studies.identify(
            speeds,
            output=output,
            rotor=rotor_file,
            set=parse_settings(settings),
            flavour=flavour,
            progress=progress,
        )
    print_parts(result.text())
    written = f"{output} has the {result.identified} done" if result.identified else f"nothing was written to {output}"
    if result.interruption:
        raise Failed(f"{result.interruption}; {written}")
    missing = len(result.speeds) - result.identified
    if missing:
        raise Failed(f"identification failed at {missing} of {len(result.speeds)} speeds; {written}")
    click.echo(f"receptances in {output}")


@contextmanager
def _progress_bars(console: Console) -> Iterator[Callable[[IdentificationProgress], None]]:
    """Yield a function that shows progress in two bars: one for all speeds, one for the speed being simulated."""
    with bars(console) as shown:
        all_speeds, this_speed = shown.add_task("speeds", total=None), shown.add_task(STARTING, total=None)

        def show(progress: IdentificationProgress) -> None:
            shown.update(all_speeds, completed=progress.speeds_done, total=progress.speeds_total)
            label = f"{progress.speed / (2.0 * math.pi):.4g} Hz"
            shown.update(this_speed, description=label, completed=progress.steps_done, total=progress.steps_total)

        yield show


COMMANDS = (identify,)
