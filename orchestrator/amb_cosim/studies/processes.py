"""Runs of a study in as many processes as there are processors."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

from amb_cosim.cosim.simulation import Progress

Case = TypeVar("Case")
CaseResult = TypeVar("CaseResult")


def simulate_in_processes(
    simulate: Callable[[Case], CaseResult], cases: Sequence[Case], progress: Progress
) -> list[CaseResult]:
    """Return what `simulate`, a function of a module, returns for each case; `progress` hears of each that is done.

    FMUs of flavour `python` hold the interpreter's lock, so that threads would run one after the other. An error of a
    case is raised, and ends the others.
    """
    with ProcessPoolExecutor(
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),  # Ctrl-C stops this process, and this process stops the others
    ) as pool:
        try:
            futures = [pool.submit(simulate, case) for case in cases]
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                progress(done, len(cases))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [future.result() for future in futures]
