"""Progress of long computations: bars in a terminal or a notebook, lines elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from amb_cosim.cosim.run.options import Progress as Report
from amb_cosim.presentation.plain_console import plain_console

PartsReport = Callable[[str, int, int], None]  # title of the part that begins, finished parts, all parts

STARTING = "starting (the first run builds the models)"
COMPUTING = "computing (the first run builds the models)"
INTERVAL = 10.0  # s between two lines
PATIENCE = 2.0  # s until the first line of a computation that reports nothing


class Bars(Progress):
    """Progress bars that can print lines instead when they are hidden.

    lines
        Whether to print the description of a bar that is hidden.
    interval
        Shortest time (s) before the first line, and between two lines.
    """

    def __init__(self, *columns: Any, lines: bool, interval: float, **options: Any) -> None:
        super().__init__(*columns, **options)
        self._lines, self._interval, self._last = lines and self.disable, interval, time.monotonic()

    @contextmanager
    def starting(self, text: str = STARTING, first: float = INTERVAL) -> Iterator[threading.Event]:
        """Print repeatedly that a simulation is starting, with the elapsed time, until the yielded event is set.

        Compiling takes minutes and reports no progress.

        Parameters
        ----------
        text
            What is printed.
        first
            Longest time (s) before the first line.
        """
        started, seconds = threading.Event(), self._interval

        def tell() -> None:
            passed, wait = 0.0, min(first, seconds)
            while not started.wait(wait):
                passed, wait = passed + wait, seconds
                self.console.print(f"{text}, {passed:.0f} s", highlight=False, soft_wrap=True)

        if self._lines:
            threading.Thread(target=tell, daemon=True).start()
        try:
            yield started
        finally:
            started.set()

    def update(self, task_id: TaskID, **changes: Any) -> None:
        """Update a bar, or print its description as a line if the interval has passed."""
        super().update(task_id, **changes)
        if self._lines and time.monotonic() >= self._last + self._interval:
            self._last = time.monotonic()
            self.console.print(self._tasks[task_id].description, highlight=False, soft_wrap=True)


def bars(console: Console, visible: bool | None = None, interval: float = INTERVAL) -> Bars:
    """Return progress bars with a description and the elapsed and remaining time; the bars vanish at the end.

    By default, the bars are hidden if standard error is neither a terminal nor a notebook; a command then prints lines
    instead.
    """
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    hidden = not (console.is_terminal or console.is_jupyter) if visible is None else not visible
    lines = visible is None and click.get_current_context(silent=True) is not None
    return Bars(*columns, console=console, transient=True, disable=hidden, lines=lines, interval=interval)


@contextmanager
def progress_bar(progress: bool | Report | None = None) -> Iterator[Report]:
    """Show a bar for one simulation, unless `progress` is a function; yield the function that reports progress."""
    if callable(progress):
        yield progress
        return
    with bars(plain_console(stderr=True), progress) as progress_bars, progress_bars.starting() as started:
        task = progress_bars.add_task(STARTING, total=None)

        def report(done: int, total: int) -> None:
            if not done:  # the first step may have to compile
                return
            started.set()
            text = f"simulating, {100.0 * done / max(total, 1):.0f} %"
            progress_bars.update(task, description=text, completed=done, total=total)

        yield report


@contextmanager
def parts_bar(progress: bool | PartsReport | None = None) -> Iterator[PartsReport]:
    """Show a bar for a computation in parts, unless `progress` is a function; yield the function that reports progress.

    The bar, or the line in its place, states the part that begins.
    """
    if callable(progress):
        yield progress
        return
    with bars(plain_console(stderr=True), progress, interval=0.0) as progress_bars:
        task = progress_bars.add_task("preparing (the first run builds the models)", total=None)

        def report(title: str, done: int, total: int) -> None:
            progress_bars.update(task, description=f"{done + 1} of {total}: {title}", completed=done, total=total)

        yield report


@contextmanager
def working(text: str = COMPUTING) -> Iterator[None]:
    """Show that a command computes without reports: a bar with the elapsed time in a terminal, lines elsewhere.

    The first line appears after `PATIENCE`, so that a command that takes longer is not silent.
    """
    with bars(plain_console(stderr=True)) as progress_bars, progress_bars.starting(text, PATIENCE):
        progress_bars.add_task(text, total=None)
        yield
