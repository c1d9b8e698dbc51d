"""Cached folders, each with a digest of its files; damaged folders are rebuilt."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

from amb_files.atomic import create_atomically

DIGEST = "sha256.txt"


def keep(folder: Path, fill: Callable[[Path], object]) -> None:
    """Create `folder` atomically with the content that `fill` writes, unless it exists and is undamaged.

    Parameters
    ----------
    folder
        The folder to create; missing parents are created.
    fill
        Function that writes files, but no folders, into a temporary folder.

    Raises
    ------
    OSError
        If the folder cannot be created; the error names the folder.
    """

    def fill_and_sign(stage: Path) -> None:
        fill(stage)
        (stage / DIGEST).write_text(_digest(stage), encoding="ascii")

    folder.parent.mkdir(parents=True, exist_ok=True)
    create_atomically(folder, fill_and_sign, is_undamaged)


def is_undamaged(folder: Path) -> bool:
    """Return whether a folder that `keep` made exists and is unchanged."""
    try:
        return (folder / DIGEST).read_text(encoding="ascii") == _digest(folder)
    except (OSError, ValueError):
        return False


def _digest(folder: Path) -> str:
    """Return the digest of the names and contents of a folder's files, except the file that contains the digest."""
    sha = hashlib.sha256()
    for file in sorted(folder.iterdir()):
        if file.name != DIGEST:
            sha.update(f"{file.name}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return sha.hexdigest()
