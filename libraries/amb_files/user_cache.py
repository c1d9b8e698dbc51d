"""The user's cache folder, or a temporary folder of this process if other users could write to the cache folder."""

from __future__ import annotations

import atexit
import logging
import os
import stat
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import platformdirs

from amb_files.temporary_folders import temporary_folder

OTHERS = stat.S_IWOTH | stat.S_IWGRP

log = logging.getLogger(__name__)
_exit_stack = ExitStack()


def user_cache() -> Path:
    """Return the user's cache folder; create it if it is missing.

    The folder contains machine code that will be loaded. Therefore, if another user owns the cache folder or can write
    to it, a temporary folder of this process is used instead, and the reason is logged once. The temporary folder is
    also used if the cache folder is not writable.
    """
    folder = platformdirs.user_cache_path("amb-cosim", appauthor=False)
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return _of_this_process("")
    if not os.access(folder, os.W_OK):
        return _of_this_process("")
    if not is_private(folder):
        return _of_this_process(f"{folder} is not used as a cache, because other users own it or may write to it")
    return folder


def is_private(folder: Path) -> bool:
    """Return whether a folder belongs to this user and can be changed or replaced only by root and the user.

    A group whose only member is the user counts as the user. A parent folder may be writable by others if, as in /tmp,
    only the owner of an entry can rename it.
    """
    if not hasattr(os, "geteuid"):  # Windows: the profile is the user's
        return True
    user = os.geteuid()
    for path in (folder := folder.resolve(), *folder.parents):
        status = path.stat()
        if status.st_uid != user and (path == folder or status.st_uid != 0):
            return False
        writable = status.st_mode & OTHERS
        if writable == stat.S_IWGRP and _has_single_member(status.st_gid):
            writable = 0
        if writable and (path == folder or not status.st_mode & stat.S_ISVTX):
            return False
    return True


def _has_single_member(number: int) -> bool:
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.geteuid()), grp.getgrgid(number)
    except KeyError:
        return False
    return user.pw_gid == number and group.gr_name == user.pw_name and not {*group.gr_mem} - {user.pw_name}


@cache
def _of_this_process(reason: str) -> Path:
    """Return a temporary folder, and log why it is needed."""
    if reason:
        log.warning("%s; this process recompiles what it needs", reason)
    atexit.register(_exit_stack.close)
    return _exit_stack.enter_context(temporary_folder())
