"""How commands print what they found."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import Any

import click
from rich.console import Console


def show(data: dict[str, Any], as_text: Callable[[dict[str, Any]], Iterable[Any]], as_json: bool) -> None:
    """Print data as JSON, or the tables and lines that `as_text` makes of it."""
    if as_json:
        click.echo(json.dumps(data, indent=2, allow_nan=False))
    else:
        print_parts(as_text(data))


def print_parts(parts: Iterable[Any]) -> None:
    """Print tables and lines."""
    console = Console()
    if not console.is_terminal:  # a file has no width to cut tables to
        console = Console(width=160)
    for part in parts:
        console.print(part)
