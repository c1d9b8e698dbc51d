"""Groups to which packs add commands, in their modules `commands`."""

from __future__ import annotations

import click

from amb_cosim.commands.cli_errors import refusing


class PackCommands(click.Group):
    """A group to which packs add commands; they are imported for a list, and for a command that is not here."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, of this package or of a pack."""
        if cmd_name not in self.commands:
            _add_commands()
        return super().get_command(ctx, cmd_name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        _add_commands()
        return super().list_commands(ctx)


def _add_commands() -> None:
    """Have the packs add their commands, which they do when they are imported."""
    from amb_files.packs import modules_of

    with refusing():
        modules_of("commands")
