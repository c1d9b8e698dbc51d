"""The processes that a process has started, and those that they have started, in whatever group or session they are.

Linux alone tells them. One whose parent has ended belongs to the nearest ancestor that adopts orphans, or to the first
process of the system.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # prctl(2)


def adopt_orphans() -> None:
    """Let what descendants of this process leave behind be its children, where the system can."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def continue_without_parent() -> None:
    """Let this process go on when its parent ends while it is stopped, where the system can; then it can end itself."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGCONT, 0, 0, 0)


def descendants(process: int) -> set[int]:
    """Return the numbers of all living processes below one; none where the system does not tell."""
    result: set[int] = set()
    for listed in Path(f"/proc/{process}/task").glob("*/children"):
        with suppress(OSError):  # it has ended meanwhile
            for child in map(int, listed.read_text().split()):
                result |= {child} | descendants(child)
    return result


def end_descendants(process: int) -> None:
    """End all processes below one, and those that they start meanwhile."""
    ended: set[int] = set()
    while new := descendants(process) - ended:
        for item in new:
            with suppress(OSError):
                os.kill(item, signal.SIGKILL)
        ended |= new
