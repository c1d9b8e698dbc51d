"""A clock for the runs of a process: a thread that sets a flag of each run periodically.

A thread per run would cost more than the initialisation of a short run.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_bool

MOST_IDLE_PERIODS = 10  # periods without a flag before the thread ends; restarting it for each short run would be slow


class Clock:
    """Sets flags to true every `period` (s), in a thread that ends when no flag has been in use for some time."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._lock = threading.Lock()
        self._flags: list[c_bool] = []
        self._ticking = False
        if hasattr(os, "register_at_fork"):  # a child process has neither the thread nor the holder of the lock
            os.register_at_fork(after_in_child=self._forget)

    @contextmanager
    def flag(self) -> Iterator[c_bool]:
        """Yield a flag."""
        flag = c_bool(False)
        with self._lock:
            self._flags.append(flag)
            if not self._ticking:
                self._ticking = True
                threading.Thread(target=self._tick, name="amb-cosim clock", daemon=True).start()
        try:
            yield flag
        finally:
            with self._lock:
                self._flags.remove(flag)

    def _forget(self) -> None:
        self._lock = threading.Lock()
        self._flags, self._ticking = [], False

    def _tick(self) -> None:
        idle = 0
        while True:
            time.sleep(self._period)
            with self._lock:
                for flag in self._flags:
                    flag.value = True
                idle = 0 if self._flags else idle + 1
                if idle == MOST_IDLE_PERIODS:
                    self._ticking = False
                    return
