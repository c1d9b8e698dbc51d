"""What Dask loads into the processes of a local cluster as they start."""

from __future__ import annotations

import signal
import threading


def dask_setup(_: object) -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the process that started them."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
