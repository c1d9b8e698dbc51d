"""A Dask preload module for the processes of a local cluster."""

from __future__ import annotations

import signal
import threading

from amb_cosim.cosim.processes.descendants import continue_without_parent


def dask_setup(_: object) -> None:
    """Ignore Ctrl-C, which a terminal sends to all processes; the parent process handles it.

    A worker ends when its parent ends. A worker that is suspended at that time is resumed, so that Dask can end it.
    """
    continue_without_parent()
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
