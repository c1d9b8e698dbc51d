"""Command groups to which applications and packs add commands, in their modules `commands`."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import click

from amb_cosim.commands.cli_errors import Refused, refusing

GENERAL = __name__.partition(".")[0]
PACKAGES: dict[click.Command, str] = {}  # of commands that this package makes for others


class PackCommands(click.Group):
    """A group to which packages add commands; the packages are imported only to list commands or to find a missing one.

    `sections` maps each heading of the help to the names of the commands listed under it. All other commands are listed
    under the name of their pack, or under a general heading. `former` maps the name of each former command to its
    replacement.
    """

    def __init__(self, *args: Any, former: dict[str, str] | None = None, **options: Any) -> None:
        super().__init__(*args, **options)
        restore_help(self)
        self.former = dict(former or {})
        self.sections: dict[str, list[str]] = {}

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the called command; refuse a former command and name its replacement."""
        if self.get_command(ctx, args[0]) is None and args[0] in self.former:
            raise Refused(f"there is no command {args[0]!r} any more; use 'amb-cosim {self.former[args[0]]}'")
        return super().resolve_command(ctx, args)

    def add_section(self, title: str, *commands: click.Command) -> None:
        """Add commands, and list them in the section with this title, after the commands that it already contains."""
        for command in commands:
            self.add_command(command)
        self.list_in_section(title, *(command.name or "" for command in commands))

    def list_in_section(self, title: str, *names: str) -> None:
        """List these commands, which may be added later, at the end of the section with this title."""
        self.sections.setdefault(title, []).extend(names)

    def add_examples(self, examples: Mapping[str, Sequence[str]]) -> None:
        """Add examples to the end of the help of commands; `rotor show` stands for the command `show` of `rotor`.

        An example is the part of a command line that follows `amb-cosim`.
        """
        for path, lines in examples.items():
            command: click.Command = self
            for name in path.split():
                command = command.commands[name]  # type: ignore[attr-defined]  # groups have them
            command.epilog = "\b\nExamples:\n" + "\n".join(f"  amb-cosim {line}" for line in lines)

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command, and restore its help if docstrings are not in memory."""
        restore_help(cmd)
        super().add_command(cmd, name)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command of this group, wherever it was defined."""
        if cmd_name not in self.commands:
            _add_commands()
        return super().get_command(ctx, cmd_name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        _add_commands()
        return super().list_commands(ctx)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands by section."""
        from amb_files.packs import packs

        names = self.list_commands(ctx)  # which adds those of other packages
        installed = packs()
        heading = {name: title for title, section in self.sections.items() for name in section}
        rest = (name for name in names if name not in heading)
        listed: dict[str, list[tuple[str, click.Command]]] = {title: [] for title in self.sections}
        for name in (*heading, *rest):
            command = self.get_command(ctx, name)
            if command is None or command.hidden:
                continue
            package = package_of(command)
            title = heading.get(name) or (f"Commands of the pack {package}" if package in installed else "Commands")
            listed.setdefault(title, []).append((name, command))
        limit = formatter.width - 6 - max(len(name) for commands in listed.values() for name, _ in commands)
        for title, commands in listed.items():
            if commands:
                with formatter.section(title):
                    formatter.write_dl([(name, command.get_short_help_str(limit)) for name, command in commands])


def restore_help(command: click.Command) -> None:
    """Set missing help texts of a command and its subcommands to the docstrings of their functions.

    The docstrings are read from the source code, because `python -OO` removes them from memory.
    """
    if command.help is None and command.callback is not None:
        command.help = _docstring(inspect.unwrap(command.callback))
    for subcommand in getattr(command, "commands", {}).values():
        restore_help(subcommand)


def _docstring(function: object) -> str | None:
    """Return the docstring in the source of a function; None if there is no docstring or no source is installed."""
    try:
        source = inspect.getsource(function)  # type: ignore[arg-type]
    except OSError:
        return None
    node = ast.parse(textwrap.dedent(source)).body[0]
    return ast.get_docstring(node) if isinstance(node, ast.FunctionDef) else None


def package_of(command: click.Command) -> str:
    """Return the package that adds a command."""
    return PACKAGES.get(command) or (command.callback.__module__ if command.callback else GENERAL).partition(".")[0]


def _add_commands() -> None:
    """Import the modules that add commands."""
    from amb_files.packs import modules_of

    with refusing():
        modules_of("commands")
