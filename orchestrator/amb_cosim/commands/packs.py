"""Command groups to which packs add commands, in their modules `commands`."""

from __future__ import annotations

from typing import Any

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.former import Group
from amb_cosim.commands.help_texts import restore_help

GENERAL = __name__.partition(".")[0]
PACKAGES: dict[click.Command, str] = {}  # of commands whose function is made here for a package


class PackCommands(Group):
    """A group to which packs add commands; they are imported for listings, and for commands not defined here.

    `sections` has the names of this package's commands by the heading under which help lists them; commands of other
    packages are listed under the package's name.
    """

    sections: dict[str, tuple[str, ...]] = {}  # noqa: RUF012, a group sets its own

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        restore_help(self)

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command, whose help needs no docstrings in memory."""
        restore_help(cmd)
        super().add_command(cmd, name)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command of this package or of a pack."""
        if cmd_name not in self.commands:
            _add_commands()
        return super().get_command(ctx, cmd_name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        _add_commands()
        return super().list_commands(ctx)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands by section."""
        heading = {name: title for title, names in self.sections.items() for name in names}
        rest = (name for name in self.list_commands(ctx) if name not in heading)
        listed: dict[str, list[tuple[str, click.Command]]] = {title: [] for title in self.sections}
        for name in (*heading, *rest):
            command = self.get_command(ctx, name)
            if command is None or command.hidden:
                continue
            package = package_of(command)
            title = heading.get(name, "Commands") if package == GENERAL else f"Package {package}"
            listed.setdefault(title, []).append((name, command))
        limit = formatter.width - 6 - max(len(name) for commands in listed.values() for name, _ in commands)
        for title, commands in listed.items():
            if commands:
                with formatter.section(title):
                    formatter.write_dl([(name, command.get_short_help_str(limit)) for name, command in commands])


def package_of(command: click.Command) -> str:
    """Return the package that adds a command."""
    return PACKAGES.get(command) or (command.callback.__module__ if command.callback else GENERAL).partition(".")[0]


def _add_commands() -> None:
    """Import the packs' modules, which add their commands."""
    from amb_files.packs import modules_of

    with refusing():
        modules_of("commands")
