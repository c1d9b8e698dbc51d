"""How long a process has been computing, which does not depend on what else the machine does."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path
from typing import Any


def processor_time(process: subprocess.Popen[Any]) -> float:
    """Return the processor time (s) of a process, and of those that it has waited for."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def let_compute(process: subprocess.Popen[Any], until: float) -> None:
    """Wait until the processor time of a process is `until` (s), or the process has ended."""
    while process.poll() is None and processor_time(process) < until:
        time.sleep(0.005)
