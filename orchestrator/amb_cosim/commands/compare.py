"""Command that compares runs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import Failed, interrupted, refuse_empty_record, refusing
from amb_cosim.commands.options import ALL, NO_PLOTS, UNITS, UNTIL, output, parse_settings
from amb_cosim.cosim.errors import computed_by
from amb_files.atomic import check_writable

NUMBERED = re.compile(r"(\d{1,3}):(.*)", re.DOTALL)


@click.command()
@click.argument("sources", nargs=-1, required=True, metavar="A B [C ...]")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="[N:]COMPONENT.VARIABLE=VALUE",
    help="Set a value in all runs, or in the Nth; units allowed.",
)
@click.option("--rotor", "rotors", multiple=True, metavar="[N:]NAME|FILE", help="Rotor of all runs, or of the Nth.")
@click.option(
    "--flavour",
    "flavours",
    multiple=True,
    metavar="[N:]native|python",
    help="FMU flavour of all runs, or of the Nth.",
)
@UNTIL
@output("Folder; default: results/comparison.")
@NO_PLOTS
@UNITS
@ALL
def compare(
    sources: tuple[str, ...],
    settings: tuple[str, ...],
    rotors: tuple[str, ...],
    flavours: tuple[str, ...],
    until: str | None,
    output: Path | None,
    no_plots: bool,
    show_all: bool,
) -> None:
    """Compare runs or saved results side by side.

    Each of A, B, ... is a scenario (its name or TOML file) or a saved result (its folder or .nc file). To apply an
    option to one run only, put the number of the run in front: --set 2:rotor_contact.*.law=hertz.
    """
    from amb_cosim.comparison import compare as comparison
    from amb_cosim.presentation.text_tables import print_parts

    folder = output or Path("results") / "comparison"
    with refusing():
        check_writable(folder, is_folder=True, files=(comparison.FILE,))
        count = len(sources)
        flavour: Any = _last(flavours, count, "--flavour") or "native"
        settings_by_run = [parse_settings(texts) for texts in _by_run(settings, count, "--set")]
        result = computed_by(
            comparison.compare,
            *sources,
            set=settings_by_run if _names_run(settings) else settings_by_run[0] if settings_by_run else None,
            rotor=_last(rotors, count, "--rotor"),
            flavour=[each or "native" for each in flavour] if isinstance(flavour, list) else flavour,
            until=until,
        )
        refuse_empty_record(result.sides[-1].result.outcome)
        result.save(folder, plots=False)
    print_parts(result.text(show_all))
    if not no_plots:  # last, so that no fault of a figure hides the comparison
        with refusing():
            result.save(folder)
    click.echo(f"results in {folder}")
    failures = [f"{side.label}: {side.result.outcome.failure}" for side in result.sides if side.result.outcome.failure]
    if failures:
        stopped = result.sides[-1].result.outcome.status == "interrupted"
        raise (interrupted if stopped else Failed)("\n".join(failures))


def _names_run(texts: Sequence[str]) -> bool:
    """Return whether any of the texts applies to a single run."""
    return any(NUMBERED.fullmatch(text) for text in texts)


def _by_run(texts: Sequence[str], count: int, option: str) -> list[list[str]]:
    """Return the texts for each run: first the texts for all runs, then the texts for this run alone."""
    for_all = [text for text in texts if not NUMBERED.fullmatch(text)]
    by_run = [list(for_all) for _ in range(count)]
    for match in filter(None, (NUMBERED.fullmatch(text) for text in texts)):
        number = int(match[1])
        if not 1 <= number <= count:
            raise ValueError(f"{option} {match[0]}: there is no run {number}; it must be from 1 to {count}")
        by_run[number - 1].append(match[2])
    return by_run


def _last(texts: Sequence[str], count: int, option: str) -> Any:
    """Return the last text, or None; if any text is for a single run, return a list with the last text for each run."""
    last = [of_run[-1] if of_run else None for of_run in _by_run(texts, count, option)]
    return last if _names_run(texts) else last[0] if last else None


COMMANDS = (compare,)
