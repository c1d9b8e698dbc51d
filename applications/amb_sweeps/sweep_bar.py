"""The progress bar of a sweep."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.progress import bars

Report = Callable[[int, int, str], None]  # finished points, all points, address of the dashboard


@contextmanager
def sweep_bar(progress: bool | Report | None = None) -> Iterator[Report]:
    """Show a bar for a sweep with its rate, the time left and the dashboard's address, unless `progress` is a function.

    Yield a function that is called with the number of finished points, the number of all points, and the address.
    """
    if callable(progress):
        yield progress
        return
    console = plain_console(stderr=True)
    with bars(console, progress) as progress_bars:
        task = progress_bars.add_task("starting processes", total=None)
        start: list[tuple[float, int]] = []
        printed: set[str] = set()

        def report(done: int, total: int, dashboard: str) -> None:
            if dashboard and dashboard not in printed and progress is not False:
                printed.add(dashboard)
                console.print(f"dashboard {dashboard}", highlight=False)
            if not start or done < start[0][1]:
                start[:] = [(time.monotonic(), done)]
            passed = time.monotonic() - start[0][0]
            rate = (done - start[0][1]) / passed if passed > 0.0 else 0.0
            text = f"{done} of {total} runs, {rate:.3g} per second"
            progress_bars.update(task, description=text, completed=done, total=total)

        yield report
