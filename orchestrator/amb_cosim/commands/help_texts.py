"""Help texts of commands in a Python without docstrings (`python -OO`, `PYTHONOPTIMIZE=2`)."""

from __future__ import annotations

import ast
import inspect
import textwrap

import click


def restore_help(command: click.Command) -> None:
    """Set the help of a command and of its subcommands to the docstrings of their functions, if they have none."""
    if command.help is None and command.callback is not None:
        command.help = _docstring(inspect.unwrap(command.callback))
    for subcommand in getattr(command, "commands", {}).values():
        restore_help(subcommand)


def _docstring(function: object) -> str | None:
    """Return the docstring in the source of a function; None if it has none or no source is installed."""
    try:
        source = inspect.getsource(function)  # type: ignore[arg-type]
    except OSError:
        return None
    node = ast.parse(textwrap.dedent(source)).body[0]
    return ast.get_docstring(node) if isinstance(node, ast.FunctionDef) else None
