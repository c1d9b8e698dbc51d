"""Kills a process of a sweep at a point of the sweep's progress."""

import os
import signal
import threading

LATEST = 0.9  # of the points


class Killer:
    """A `progress` of a sweep that kills a process after so many points, and so long (s) after their report.

    A sweep that has come to `LATEST` by then loses the process at once: the kill is in time on any machine.
    """

    def __init__(self, process: int, points: int, delay: float) -> None:
        self._process, self._points, self._timer = process, points, threading.Timer(delay, self._kill)
        self._lock, self._begun, self._fired = threading.Lock(), False, False

    def __call__(self, done: int, total: int, dashboard: str) -> None:
        if done >= self._points and not self._begun:
            self._begun = True
            self._timer.start()
        if done >= LATEST * total:
            self._kill()

    def _kill(self) -> None:
        with self._lock:
            if not self._fired:
                os.kill(self._process, signal.SIGKILL)
                self._fired = True
