"""A Dask preload of the processes of a local cluster."""

from __future__ import annotations

import signal
import threading


def dask_setup(_: object) -> None:
    """Ignore Ctrl-C, which a terminal sends to all processes; the parent process handles it."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
