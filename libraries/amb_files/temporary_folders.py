"""Temporary folders, which are removed by their process when it ends or, if it is killed, by a later process."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl

PREFIX = ".amb-cosim-"


@contextmanager
def temporary_folder(parent: Path | None = None) -> Iterator[Path]:
    """Yield a new folder in `parent` (default: the system's folder for temporary files), and remove it afterwards.

    The folder is locked until it is removed or the process ends for any reason. Unlocked folders that this function
    made earlier for the same user are removed from `parent`; a digest at the end of their names identifies them.
    """
    parent = Path(tempfile.gettempdir()) if parent is None else parent
    _remove_abandoned(parent)
    folder, lock = parent / _name(secrets.token_hex(8)), None
    try:
        lock = _create_locked(folder)
        yield folder
    finally:  # also for a signal during the creation of the folder
        shutil.rmtree(folder, ignore_errors=True)
        _unlock(lock)


def _create_locked(folder: Path) -> int | None:
    """Create a folder and lock it; repeat if another process removes it before it is locked."""
    while True:
        folder.mkdir(mode=0o700)
        try:
            lock = _lock(folder, wait=True)
        except FileNotFoundError:
            continue
        except OSError:  # a file system without locks; nothing is removed from it
            return None
        if folder.is_dir():
            return lock
        _unlock(lock)


def _name(token: str) -> str:
    """Return a folder name that ends with a digest of its beginning, by which the folder is recognised later."""
    return f"{PREFIX}{token}-{hashlib.sha256(f'{PREFIX}{token}'.encode()).hexdigest()[:16]}"


def _is_ours(folder: Path) -> bool:
    """Return whether `temporary_folder` made a folder for this user."""
    token = re.fullmatch(f"{re.escape(PREFIX)}([0-9a-f]{{16}})-[0-9a-f]{{16}}", folder.name)
    try:
        return token is not None and folder.name == _name(token[1]) and folder.lstat().st_uid == os.geteuid()
    except OSError:
        return False


def _remove_abandoned(parent: Path) -> None:
    if sys.platform == "win32":
        return
    for folder in parent.glob(f"{PREFIX}*"):
        if not _is_ours(folder):
            continue
        with suppress(OSError):  # it is in use, or another user's
            lock = _lock(folder, wait=False)
            shutil.rmtree(folder, ignore_errors=True)
            _unlock(lock)


def _lock(folder: Path, wait: bool) -> int | None:
    """Lock a folder and return a descriptor for `_unlock`; raise OSError for a locked folder if `wait` is false."""
    if sys.platform == "win32":
        return None
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _unlock(lock: int | None) -> None:
    if lock is not None:
        os.close(lock)
