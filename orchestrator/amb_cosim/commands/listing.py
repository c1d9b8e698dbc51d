"""The command that lists scenarios and sweeps, or shows everything about one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import click

from amb_cosim.commands.cli_errors import refusing

if TYPE_CHECKING:
    from rich.console import Console

T = TypeVar("T")
SWEEPS = "sweeps"  # theme of sweeps
OTHERS = "others"  # theme of scenarios without one


class ListedItem(NamedTuple):
    """A scenario or a sweep: its description, and the words that find it."""

    name: str
    file: Path
    theme: str
    description: str
    outcome: str
    source: str

    def has(self, words: tuple[str, ...]) -> bool:
        """Whether its description contains all words."""
        text = " ".join((self.name, self.theme, self.description, self.outcome, self.source)).lower()
        return all(word in text for word in words)


@click.command("list")
@click.argument("name", required=False)
@click.option("--filter", "words", metavar="WORDS", default="", help="List only entries that contain all these words.")
def list_scenarios(name: str | None, words: str) -> None:
    """List scenarios and sweeps, or show all of NAME."""
    from amb_cosim.presentation.plain_console import plain_console
    from amb_files.pack_file import pack_files
    from amb_files.packs import packs
    from amb_files.suggestions import suggest

    with refusing():
        entries, said = list(_entries()), pack_files()
        if name is not None:
            item = next((entry for entry in entries if entry.name == name), None)
            if item is None:
                names = [entry.name for entry in entries]
                raise ValueError(f"there is no scenario or sweep {name}; {suggest(name, names)}")
            _tell(item)
            return
        wanted = tuple(words.lower().split())
        entries = [entry for entry in entries if entry.has(wanted)]
        if not entries:
            raise ValueError(f"no scenario and no sweep has the words {words!r}")
    console, width = plain_console(), max(len(entry.name) for entry in entries)
    for pack, folder in packs().items():
        of_pack = [entry for entry in entries if entry.file.parents[1] == folder]
        if of_pack:
            _line(console, f"{pack}: {said[pack].description}" if pack in said else pack, style="bold")
        for theme in sorted({entry.theme for entry in of_pack}, key=lambda theme: (theme == SWEEPS, theme)):
            _line(console, f"  {theme}", style="italic")
            for entry in of_pack:
                if entry.theme == theme:
                    _line(console, f"    {entry.name:{width}}  {entry.description}")
    _line(console, "Details: amb-cosim list NAME. To run: amb-cosim run NAME, amb-cosim sweep NAME.")


def _entries() -> Iterator[ListedItem]:
    """Yield the scenarios and the sweeps of all packs; an invalid one is skipped with a warning."""
    from amb_cosim.scenario.file import packaged_scenarios
    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.studies.stored_robustness import stored_outcomes
    from amb_cosim.sweeps.ready import read_sweep
    from amb_files.packs import files_of

    available, files = stored_outcomes(), files_of("scenarios")
    for name in packaged_scenarios():
        if (item := _readable(files[name], load_scenario, name)) is None:
            continue
        outcome = f"{available[name].outcome}; {available[name].verdict}" if name in available else ""
        yield ListedItem(name, files[name], item.theme or OTHERS, item.description, outcome, item.source)
    files = files_of("sweeps")
    for name, file in files.items():
        if (ready := _readable(file, read_sweep, name, file)) is None:
            continue
        yield ListedItem(name, files[name], SWEEPS, ready.description, "", f"sweep of {ready.scenario}")


def _readable(file: Path, read: Callable[..., T], *arguments: str | Path) -> T | None:
    """Return what a function reads from a file of a pack, or None with a warning if that is invalid."""
    from amb_files.packs import pack_of

    try:
        return read(*arguments)
    except ValueError as error:
        click.echo(f"warning: pack {pack_of(file)}: {error}", err=True)
        return None


def _line(console: Console, text: str, style: str | None = None) -> None:
    """Print a line, cut to the width of the terminal."""
    if console.is_terminal:
        console.print(text, style=style, no_wrap=True, overflow="ellipsis", markup=False, highlight=False)
    else:
        click.echo(text)


def _tell(entry: ListedItem) -> None:
    """Print everything about a scenario or a sweep."""
    for label in ("name", "theme", "description", "outcome", "source", "file"):
        if text := str(getattr(entry, label)):
            click.echo(f"{label:12} {text}")


COMMANDS = (list_scenarios,)
