"""Progress bars."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from amb_cosim.cosim.run.options import Progress as Report
from amb_cosim.presentation.plain_console import plain_console

SweepReport = Callable[[int, int, str], None]  # points done, their number, address of the dashboard

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


@contextmanager
def sweep_bar(progress: bool | SweepReport | None = None) -> Iterator[SweepReport]:
    """Show a bar for a sweep with its rate, the time left and the dashboard's address, unless `progress` is a function.

    Yield a function to call with the number of finished points, of all points, and the address.
    """
    if callable(progress):
        yield progress
        return
    console = plain_console(stderr=True)
    with bars(console, progress) as displayed:
        task = displayed.add_task("starting processes", total=None)
        began: list[tuple[float, int]] = []
        message: set[str] = set()

        def report(done: int, total: int, dashboard: str) -> None:
            if dashboard and dashboard not in message:
                message.add(dashboard)
                console.print(f"dashboard {dashboard}", highlight=False)
            if not began or done < began[0][1]:
                began[:] = [(time.monotonic(), done)]
            passed = time.monotonic() - began[0][0]
            rate = (done - began[0][1]) / passed if passed > 0.0 else 0.0
            text = f"{done} of {total} runs, {rate:.3g} a second"
            displayed.update(task, description=text, completed=done, total=total)

        yield report
