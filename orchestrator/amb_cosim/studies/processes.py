"""Runs of a study in parallel processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import TypeVar

from amb_cosim.cosim.basics.interruption import deferred
from amb_cosim.cosim.run.run_plan import Progress

Case = TypeVar("Case")
CaseResult = TypeVar("CaseResult")

POLL_INTERVAL = 0.1  # s, until an interruption is noticed


def simulate_in_processes(
    simulate: Callable[[Case], CaseResult], cases: Sequence[Case], progress: Progress, processes: int | None = None
) -> list[CaseResult]:
    """Return what `simulate`, a function of a module, returns for each case; `progress` hears of each that is done.

    There are at most `processes`, by default as many as there are processors.

    FMUs of flavour `python` hold the interpreter's lock, so that threads would run one after the other. An error of a
    case is raised, and ends the others. Whatever ends this process ends them too. An interruption is put off until no
    function of the pool is under way: it would leave locks of futures taken, for which the pool then waits.
    """
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
        except BaseException:
            end_of_this.close()
            pool.shutdown(cancel_futures=True)
            raise
    return [future.result() for future in futures]


def _follow(parent: Connection) -> None:
    """End this process when the other end of the pipe is closed, by its process or because that is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C stops the process that started this one
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Connection) -> None:
    with suppress(EOFError, OSError):
        parent.recv_bytes()
    os._exit(1)
