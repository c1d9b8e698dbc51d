"""Compiling in processes: one of them compiles, and others that need the same code wait for its result on disk."""

from __future__ import annotations

import gc
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

SILENT_WAIT = 1.0  # s of waiting without a message

log = logging.getLogger(__name__)


def import_path() -> str:
    """Return a value of PYTHONPATH with which another process imports the modules that this one would import."""
    return os.pathsep.join(str(Path(entry).absolute()) for entry in sys.path)


def collect_garbage_rarely() -> None:
    """Let a process that only compiles collect garbage rarely, which by default takes a tenth of its time."""
    gc.set_threshold(100_000, 50, 1000)


@contextmanager
def compiling(place: Path, what: str) -> Iterator[None]:
    """Let one process at a time make a file or folder; if the process dies, the operating system releases its lock.

    A process that has waited uses the result if it exists, and otherwise makes it. If locks are not supported, no
    process waits.

    Parameters
    ----------
    place
        File or folder to make; a lock file exists beside it during the work.
    what
        Description of the result for the message of waiting processes.
    """
    lock = Path(f"{place}.lock")
    with ExitStack() as stack:
        with suppress(ImportError, OSError, NotImplementedError):  # the host of an FMU may lack it
            lock.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(_notice(lock, what))
            stack.callback(_remove, lock)
        yield


@contextmanager
def _notice(path: Path, what: str) -> Iterator[None]:
    from filelock import FileLock, Timeout  # takes 0.1 s to load, and is rarely needed

    lock = FileLock(path)
    try:
        lock.acquire(timeout=SILENT_WAIT)
    except Timeout:
        log.warning("waiting for another process to make %s", what)
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def _remove(lock: Path) -> None:
    with suppress(OSError):  # Windows does not delete open files
        lock.unlink()
