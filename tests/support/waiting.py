"""Watching other processes and threads, and waiting for them, however slow a loaded machine makes them."""

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

LONGEST = 300.0  # s; only what hangs takes as long


def wait_until(condition: Callable[[], object], pause: float = 0.02) -> None:
    """Wait until a condition holds; fail the test after a time limit."""
    end = time.monotonic() + LONGEST
    while not condition():
        assert time.monotonic() < end, f"waited {LONGEST:g} s in vain"
        time.sleep(pause)


def of_process(process: int, file: str) -> str:
    """Return the content of a file of a process in `/proc`; nothing if the process has ended."""
    try:
        return Path(f"/proc/{process}/{file}").read_text(encoding="utf-8", errors="replace")
    except OSError:  # it may also end between the opening of the file and its reading
        return ""


def children(process: int) -> list[int]:
    """Return the processes that the main thread of a process has started and that it has not waited for."""
    return [int(number) for number in of_process(process, f"task/{process}/children").split()]


def is_running(process: int) -> bool:
    """Return whether a process exists and is no zombie, which an init that adopts orphans may leave."""
    status = of_process(process, "status")
    return bool(status) and "State:\tZ" not in status


def processor_time(process: int) -> float:
    """Return the CPU time (s) of a process and of the children that it has waited for."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def wait_for_work(process: int, seconds: float) -> None:
    """Wait until a process has used that many more seconds of CPU time."""
    begin = processor_time(process)
    wait_until(lambda: processor_time(process) >= begin + seconds)


def let_compute(process: subprocess.Popen[Any], until: float) -> None:
    """Wait until the processor time of a process is `until` (s), or the process has ended."""
    while process.poll() is None and processor_time(process.pid) < until:
        time.sleep(0.005)
