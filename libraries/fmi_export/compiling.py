"""Compiling by one process, while others that need the same wait for what it keeps on disk."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

UNTOLD = 1.0  # s that nobody is told of

log = logging.getLogger(__name__)


@contextmanager
def compiling(place: Path, what: str) -> Iterator[None]:
    """Let one process at a time make what is kept at a place; the operating system lets the next in where it dies.

    Who had to wait finds it there, or makes it. Where there can be no lock, nobody waits.

    Parameters
    ----------
    place
        File or folder that is made; the lock is beside it, and goes with the work.
    what
        What those who wait say that they wait for.
    """
    lock = Path(f"{place}.lock")
    with ExitStack() as stack:
        with suppress(ImportError, OSError, NotImplementedError):  # the host of an FMU has what it has
            lock.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(_told(lock, what))
            stack.callback(_remove, lock)
        yield


@contextmanager
def _told(path: Path, what: str) -> Iterator[None]:
    from filelock import FileLock, Timeout  # takes 0.1 s to load, and is needed seldom

    lock = FileLock(path)
    try:
        lock.acquire(timeout=UNTOLD)
    except Timeout:
        log.warning("waiting for another process, which makes %s", what)
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def _remove(lock: Path) -> None:
    with suppress(OSError):  # Windows keeps a file that others have open
        lock.unlink()
