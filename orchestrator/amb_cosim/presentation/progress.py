"""Progress bars."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from amb_cosim.cosim.run.options import Progress as Report
from amb_cosim.presentation.plain_console import plain_console

STARTING = "starting (a first run compiles the models)"


def bars(console: Console, visible: bool | None = None) -> Progress:
    """Return progress bars with a description, elapsed and remaining time, which vanish at the end.

    By default there are none if standard error is neither a terminal nor a notebook.
    """
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    hidden = not (console.is_terminal or console.is_jupyter) if visible is None else not visible
    return Progress(*columns, console=console, transient=True, disable=hidden)


@contextmanager
def progress_bar(progress: bool | Report | None = None) -> Iterator[Report]:
    """Show a bar for one simulation, unless `progress` is a function; yield the function for the steps done."""
    if callable(progress):
        yield progress
        return
    with bars(plain_console(stderr=True), progress) as displayed:
        task = displayed.add_task(STARTING, total=None)
        yield lambda done, total: displayed.update(task, description="simulating", completed=done, total=total)
