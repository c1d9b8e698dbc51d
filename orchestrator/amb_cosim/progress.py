"""Progress bars."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from amb_cosim.cosim.simulation import Progress as Report

STARTING = "starting (a first run compiles the models)"


def bars(console: Console, shown: bool | None = None) -> Progress:
    """Return progress bars with a description, the time passed and the time left, which vanish at the end.

    Unless `shown` says otherwise there are none where standard error is neither a terminal nor a notebook.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    hidden = not (console.is_terminal or console.is_jupyter) if shown is None else not shown
    return Progress(*columns, console=console, transient=True, disable=hidden)


@contextmanager
def progress_bar(progress: bool | Report | None = None) -> Iterator[Report]:
    """Show a bar for one simulation, unless `progress` is a function; yield what is called with the steps done."""
    if callable(progress):
        yield progress
        return
    with bars(Console(stderr=True), progress) as shown:
        task = shown.add_task(STARTING, total=None)
        yield lambda done, total: shown.update(task, description="simulating", completed=done, total=total)
