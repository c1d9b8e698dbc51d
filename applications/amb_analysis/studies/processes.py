"""Runs in parallel processes, each of which imports the user's script (multiprocessing's `spawn`)."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import process
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TypeVar

from amb_cosim.cosim.processes.descendants import continue_without_parent
from amb_cosim.cosim.processes.interruption import deferred
from amb_cosim.cosim.run.options import Progress

Case = TypeVar("Case")
CaseResult = TypeVar("CaseResult")

POLL_INTERVAL = 0.1  # s, until an interruption is noticed


def simulate_in_processes(
    simulate: Callable[[Case], CaseResult], cases: Sequence[Case], progress: Progress, processes: int | None = None
) -> list[CaseResult]:
    """Return the results of the module-level function `simulate` for all cases; call `progress` as cases finish.

    At most `processes` processes run at once; the default is one per processor.

    Processes are used instead of threads, because FMUs of flavour `python` hold the interpreter's lock. If a case
    raises an error, the other cases end and the error is raised here. The processes end when the calling process ends.
    An interruption is delayed while a function of the pool runs. Otherwise, a future's lock could stay held, and the
    pool would wait for this lock forever.

    Raises
    ------
    ValueError
        If processes end while they start. Each process imports the user's script, which must be a file with a main
        guard.
    """
    end_if_imported_anew()
    check_script()
    context = multiprocessing.get_context("spawn")
    parent_end, child_end = context.Pipe()
    with (
        deferred() as interruption,
        ProcessPoolExecutor(processes, context, _end_with_parent, (child_end,)) as pool,
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
            raise ValueError(f"processes of the study ended unexpectedly; {main_guard_advice('it')}") from None
        except BaseException:
            parent_end.close()
            pool.shutdown(cancel_futures=True)
            raise
    return [future.result() for future in futures]


def _end_with_parent(parent: Connection) -> None:
    """End this process when the parent process ends or closes its end of the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C stops the process that started this one
    continue_without_parent()
    threading.Thread(target=_end_at_close, args=(parent,), daemon=True).start()


def _end_at_close(parent: Connection) -> None:
    with suppress(EOFError, OSError):
        parent.recv_bytes()
    os._exit(1)


def end_if_imported_anew() -> None:
    """End this process if it was just started and is importing a script without a main guard (`main_guard_advice`)."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)


def check_script() -> None:
    """Check that new processes can import the script that Python runs, if there is one."""
    main = sys.modules["__main__"]
    script = getattr(main, "__file__", None)
    if script is None or getattr(main, "__spec__", None) is not None:
        return  # an interactive session, or a module that processes import by name
    if not Path(getattr(process, "ORIGINAL_DIR", None) or "", script).is_file():
        is_input = script == "<stdin>"
        reason = "Python reads the script from standard input" if is_input else f"the script {script} is not a file"
        raise ValueError(f"{reason}, but the processes started here must import the script; save it as a file")


def main_guard_advice(function: str) -> str:
    """Return advice to call `function` below a main guard, because each process imports the script."""
    return f'a script must call {function} below if __name__ == "__main__":, because each process imports the script'
