"""Waiting for other processes and threads, however slow a loaded machine makes them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

LONGEST = 300.0  # s; only what hangs takes as long


def wait_until(condition: Callable[[], object], pause: float = 0.02) -> None:
    """Wait until a condition holds; what hangs fails the test."""
    end = time.monotonic() + LONGEST
    while not condition():
        assert time.monotonic() < end, f"waited {LONGEST:g} s in vain"
        time.sleep(pause)


def wait_for_work(process: int, seconds: float) -> None:
    """Wait until a process has computed for so many more seconds of processor time, on Linux."""
    begin = _processor_time(process)
    wait_until(lambda: _processor_time(process) >= begin + seconds)


def _processor_time(process: int) -> float:
    numbers = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")
