"""Folders of what was made once, with a digest of their files: one that is damaged is made anew."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

from amb_files.atomic import create_atomically

DIGEST = "sha256.txt"


def keep(folder: Path, fill: Callable[[Path], object]) -> None:
    """Create `folder` with what `fill` puts into it, whole or not at all; do nothing if it is there, undamaged.

    Parameters
    ----------
    folder
        The folder to create; parents are made if they are missing.
    fill
        Writes files, and no folders, into the temporary folder that it is given.

    Raises
    ------
    OSError
        If it cannot be created; the error names it.
    """

    def fill_and_sign(stage: Path) -> None:
        fill(stage)
        (stage / DIGEST).write_text(_digest(stage), encoding="ascii")

    folder.parent.mkdir(parents=True, exist_ok=True)
    create_atomically(folder, fill_and_sign, is_undamaged)


def is_undamaged(folder: Path) -> bool:
    """Return whether there is a folder that `keep` made and that nothing has changed since."""
    try:
        return (folder / DIGEST).read_text(encoding="ascii") == _digest(folder)
    except (OSError, ValueError):
        return False


def _digest(folder: Path) -> str:
    """Return the digest of the names and the content of the other files of a folder."""
    sha = hashlib.sha256()
    for file in sorted(folder.iterdir()):
        if file.name != DIGEST:
            sha.update(f"{file.name}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return sha.hexdigest()
