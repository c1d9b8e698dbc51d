"""The command that lists scenarios and the entries of applications, or shows everything about one of them.

An application adds entries in its module `listing`: `entries()` returns the entries, and `outcomes()` returns outcomes
by scenario.
"""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from amb_cosim.commands.cli_errors import refusing

if TYPE_CHECKING:
    from rich.console import Console

T = TypeVar("T")
MOST_FILES = 20  # of a pack, with warnings
OTHERS = "others"  # theme of scenarios without one


class ListedItem(NamedTuple):
    """A scenario, or an entry that an application bases on a scenario, with the texts that `--filter` searches.

    `command` is the command that runs it.
    """

    name: str
    file: Path
    theme: str
    description: str
    outcome: str
    source: str
    command: str = "run"

    def has(self, words: tuple[str, ...]) -> bool:
        """Return whether the texts of the item contain all words."""
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
        entries = list(_entries())
        if name is not None:
            entry = next((entry for entry in entries if entry.name == name), None)
            if entry is None:
                names = [entry.name for entry in entries]
                raise ValueError(f"there is no entry {name}; {suggest(name, names)}")
            for label in ("name", "theme", "description", "outcome", "source", "file"):
                if text := str(getattr(entry, label)):
                    click.echo(f"{label:12} {text}")
            return
        required = tuple(words.lower().split())
        entries = [entry for entry in entries if entry.has(required)]
        if not entries:
            raise ValueError(f"no entry contains the words {words!r}")
    console, described = plain_console(), pack_files()
    for pack, folder in packs().items():
        of_pack = [entry for entry in entries if entry.file.parents[1] == folder]
        if of_pack:
            _line(console, f"{pack}: {described[pack].description}" if pack in described else pack, style="bold")
        for _, theme in sorted({(entry.command != "run", entry.theme) for entry in of_pack}):
            _line(console, f"  {theme}", style="italic")
            of_theme = [entry for entry in of_pack if entry.theme == theme]
            width = max(len(entry.name) for entry in of_theme)
            for entry in of_theme:
                _line(console, f"    {entry.name:{width}}  {entry.description}", indent=6 + width)
    run = ", ".join(f"amb-cosim {command} NAME" for command in sorted({entry.command for entry in entries}))
    _line(console, f"Details: amb-cosim list NAME. To run: {run}.")


def _entries() -> Iterator[ListedItem]:
    """Yield the scenarios of all packs and the entries of applications; warn of invalid scenarios and skip them."""
    from amb_cosim.presentation.units import speed_unit, with_speeds_in
    from amb_cosim.scenario.file import packaged_scenarios
    from amb_cosim.scenario.scenario import load_scenario
    from amb_files.packs import files_of, modules_of

    applications, files = modules_of("listing", "entries", "outcomes"), files_of("scenarios")
    for sentence in files.clashes():
        click.echo(f"warning: {sentence}", err=True)
    outcomes = dict(_of_applications(applications, "outcomes", _outcomes))
    for name in packaged_scenarios():
        if (read := readable(files[name], load_scenario, name)) is not None:
            outcome = outcomes.get(name, "")
            description = with_speeds_in(read.description, speed_unit())
            yield ListedItem(name, files[name], read.theme or OTHERS, description, outcome, read.source)
    yield from _of_applications(applications, "entries", _items)


def _of_applications(
    modules: Mapping[str, ModuleType], name: str, checked: Callable[[Any], Iterable[T]]
) -> Iterator[T]:
    """Yield the entries that a function of the modules `listing` returns; if the function fails, print a warning."""
    from amb_files.packs import reason

    for home, module in modules.items():
        try:
            yield from checked(getattr(module, name)())
        except Exception as error:  # whatever the code of an application or pack raises
            click.echo(f"warning: {home!r} lists no {name}, because its code fails: {reason(error)}", err=True)


def _outcomes(outcomes: Mapping[str, str]) -> list[tuple[str, str]]:
    if not isinstance(outcomes, Mapping) or not all(
        isinstance(text, str) for pair in outcomes.items() for text in pair
    ):
        raise TypeError("outcomes() must map names of scenarios to texts")
    return list(outcomes.items())


def _items(entries: Iterable[ListedItem]) -> list[ListedItem]:
    items = list(entries)
    if not all(isinstance(item, ListedItem) for item in items):
        raise TypeError("entries() must return items of the type ListedItem")
    return items


def readable(file: Path, read: Callable[..., T], *arguments: object) -> T | None:
    """Return the result of a function that reads a pack's file; if the file is invalid, warn and return None.

    A command prints a warning for each of the first few invalid files of a pack, and a single warning for all further
    ones.
    """
    from amb_files.packs import pack_of

    try:
        return read(*arguments)
    except ValueError as error:
        pack, context = pack_of(file), click.get_current_context()
        warned = context.meta.setdefault(__name__, Counter())
        warned[pack] += 1
        if warned[pack] <= MOST_FILES:
            for line in str(error).splitlines():
                click.echo(f"warning: pack {pack}: {line}", err=True)
        elif warned[pack] == MOST_FILES + 1:
            click.echo(f"warning: pack {pack}: further invalid files of this pack are not listed", err=True)
        return None


def _line(console: Console, text: str, style: str | None = None, indent: int = 4) -> None:
    """Print a line; on a terminal, wrap it and indent its continuation, so that descriptions are shown in full."""
    if not console.is_terminal:
        click.echo(text)
        return
    indent = min(indent, console.width // 2)
    lines = textwrap.wrap(
        text, console.width, subsequent_indent=" " * indent, drop_whitespace=True, break_on_hyphens=False
    )
    for line in lines:
        console.print(line, style=style, no_wrap=True, overflow="ellipsis", markup=False, highlight=False)


COMMANDS = (list_scenarios,)
