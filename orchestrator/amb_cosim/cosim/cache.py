"""The folder of what is built and unpacked once: the user's, or one of this process where that cannot be written."""

from __future__ import annotations

import hashlib
import os
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import platformdirs

from amb_files.archive import is_unpacked, unpack
from amb_files.atomic import create_atomically
from amb_files.stages import stage

LONGEST_NAME = 60  # characters of a file's name that the name of its folder takes over

_own = ExitStack()


def cache_folder() -> Path:
    """Return the folder of built and unpacked FMUs."""
    folder = platformdirs.user_cache_path("amb-cosim", appauthor=False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return _of_this_process()
    return folder if os.access(folder, os.W_OK) else _of_this_process()


def unpacked(archive: Path, name: str) -> tuple[Path, bool]:
    """Return the folder of the cache that an archive is unpacked to, and whether it is new; `name` is for messages.

    The folder is named by the archive's content. One that does not hold what the archive does is made anew.

    Raises
    ------
    ValueError
        If the archive cannot be read or unpacked.
    """
    try:
        digest = hashlib.sha256(archive.read_bytes()).hexdigest()[:32]
    except OSError as error:
        raise ValueError(f"{name} cannot be read: {error.strerror or error}") from error
    home = cache_folder() / f"{archive.stem[:LONGEST_NAME]}-{digest}"
    is_new = not home.is_dir()
    create_atomically(home, lambda folder: unpack(archive, folder, name), lambda folder: is_unpacked(archive, folder))
    return home, is_new


@cache
def _of_this_process() -> Path:
    """Return a temporary folder that goes with the process."""
    import atexit

    atexit.register(_own.close)
    return _own.enter_context(stage())
