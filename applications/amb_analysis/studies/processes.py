"""Runs of a study in parallel processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import TypeVar

from amb_analysis.studies.spawned_processes import check_script, end_if_imported_anew, main_guard_advice
from amb_cosim.cosim.basics.descendants import continue_without_parent
from amb_cosim.cosim.basics.interruption import deferred
from amb_cosim.cosim.run.options import Progress

Case = TypeVar("Case")
CaseResult = TypeVar("CaseResult")

POLL_INTERVAL = 0.1  # s, until an interruption is noticed


def simulate_in_processes(
    simulate: Callable[[Case], CaseResult], cases: Sequence[Case], progress: Progress, processes: int | None = None
) -> list[CaseResult]:
    """Return the results of `simulate`, a module-level function, for all cases; `progress` is called after each.

    At most `processes` run at once; by default one per processor.

    Processes are used because FMUs of flavour `python` hold the interpreter's lock. An error in a case is raised and
    ends the others, and all end with this process. An interruption is delayed while a function of the pool runs: it
    could leave locks of futures taken, and the pool would wait for them forever.

    Raises
    ------
    ValueError
        If processes end as they start: each imports the user's script, a file with a main guard.
    """
    end_if_imported_anew()
    check_script()
    context = multiprocessing.get_context("spawn")
    end_of_this, end_of_others = context.Pipe()
    with (
        deferred() as interruption,
        ProcessPoolExecutor(processes, context, _follow, (end_of_others,)) as pool,
    ):
        try:
            futures = [pool.submit(simulate, case) for case in cases]
            running = set(futures)
            while running:
                done, running = wait(running, POLL_INTERVAL, FIRST_COMPLETED)
                interruption.check()
                for future in done:
                    future.result()
                if done:
                    progress(len(cases) - len(running), len(cases))
        except BrokenProcessPool:
            raise ValueError(f"processes of the study ended; {main_guard_advice('it')}") from None
        except BaseException:
            end_of_this.close()
            pool.shutdown(cancel_futures=True)
            raise
    return [future.result() for future in futures]


def _follow(parent: Connection) -> None:
    """End this process when the other end of the pipe closes, on purpose or because its process has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C stops the process that started this one
    continue_without_parent()
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Connection) -> None:
    with suppress(EOFError, OSError):
        parent.recv_bytes()
    os._exit(1)
