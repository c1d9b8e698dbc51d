"""The descendants of a process, in any group or session.

Only Linux provides this list. A process whose parent has ended belongs to the nearest ancestor that adopts orphans, or
to the first process of the system.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # prctl(2)


def adopt_orphans() -> None:
    """Let this process adopt orphaned descendants, if the system supports it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def continue_without_parent() -> None:
    """If the parent ends while this process is stopped, let this process continue and end itself (where supported)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGCONT, 0, 0, 0)


def descendants(process: int) -> set[int]:
    """Return the IDs of all living descendants of a process; none if the system does not list them."""
    result: set[int] = set()
    for children in Path(f"/proc/{process}/task").glob("*/children"):
        with suppress(OSError):  # it has ended meanwhile
            for child in map(int, children.read_text().split()):
                result |= {child} | descendants(child)
    return result


def end_descendants(process: int) -> None:
    """End all descendants of a process, including processes started in the meantime."""
    ended: set[int] = set()
    while new := descendants(process) - ended:
        for pid in new:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        ended |= new


def end_with_parent(wait: Callable[[], object]) -> None:
    """Start a thread that ends this process, with all its descendants, when its parent has ended.

    Parameters
    ----------
    wait
        Function that returns when the parent has ended.
    """
    adopt_orphans()
    continue_without_parent()

    def wait_and_end() -> None:
        wait()
        end_descendants(os.getpid())
        if sys.platform != "win32" and os.getpgrp() == os.getpid():
            os.killpg(0, signal.SIGKILL)  # with what FMUs have started
        os._exit(1)

    threading.Thread(target=wait_and_end, daemon=True).start()
