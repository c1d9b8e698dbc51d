"""Bars that tell how far a command has come."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

STARTING = "starting (a first run compiles the models)"


def bars(console: Console) -> Progress:
    """Room for bars with a description, the time passed and the time left; they vanish at the end.

    There are none where standard error is no terminal: a file would get an empty line.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


@contextmanager
def simulating(console: Console) -> Iterator[Callable[[int, int], None]]:
    """A bar for one simulation; what it yields is called with what is done and how much there is."""
    with bars(console) as bar:
        task = bar.add_task(STARTING, total=None)
        yield lambda done, total: bar.update(task, description="simulating", completed=done, total=total)
