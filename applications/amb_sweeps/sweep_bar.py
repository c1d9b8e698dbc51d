"""The progress bar of a sweep."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.progress import bars

Report = Callable[[int, int, str], None]  # points done, their number, address of the dashboard


@contextmanager
def sweep_bar(progress: bool | Report | None = None) -> Iterator[Report]:
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
        dashboards: set[str] = set()

        def report(done: int, total: int, dashboard: str) -> None:
            if dashboard and dashboard not in dashboards:
                dashboards.add(dashboard)
                console.print(f"dashboard {dashboard}", highlight=False)
            if not began or done < began[0][1]:
                began[:] = [(time.monotonic(), done)]
            passed = time.monotonic() - began[0][0]
            rate = (done - began[0][1]) / passed if passed > 0.0 else 0.0
            text = f"{done} of {total} runs, {rate:.3g} a second"
            displayed.update(task, description=text, completed=done, total=total)

        yield report
