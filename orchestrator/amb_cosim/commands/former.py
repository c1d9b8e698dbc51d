"""Former commands and options, and their replacements."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from amb_cosim.commands.cli_errors import Refused

Command = TypeVar("Command", bound=Callable[..., Any])


class Group(click.Group):
    """A group whose `former` has the names of commands that left, with the command in place of each."""

    def __init__(self, *args: Any, former: dict[str, str] | None = None, **options: Any) -> None:
        super().__init__(*args, **options)
        self.former = dict(former or {})

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the called command; a former one is refused with its replacement."""
        if self.get_command(ctx, args[0]) is None and args[0] in self.former:
            raise Refused(f"there is no command {args[0]!r} any more; use 'amb-cosim {self.former[args[0]]}'")
        return super().resolve_command(ctx, args)


def former_option(name: str, present: str) -> Callable[[Command], Command]:
    """Return a hidden option that is refused with the option in its place."""

    def refuse(_: click.Context, __: click.Parameter, value: str | None) -> None:
        if value is not None:
            raise Refused(f"there is no option {name} any more; use '{present}'")

    return click.option(name, hidden=True, expose_value=False, callback=refuse)
