"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with a temporary path beside `path`, then move the result there, whole or not at all.

    Parameters
    ----------
    path
        The file; one that exists is replaced. Its folder must exist.
    write
        Writes the file at the path that it is given.
    """
    with tempfile.TemporaryDirectory(prefix=".", dir=path.parent) as folder:
        temporary = Path(folder) / path.name
        write(temporary)
        temporary.replace(path)


def create_atomically(folder: Path, fill: Callable[[Path], object]) -> None:
    """Create `folder` with what `fill` puts into it, whole or not at all; do nothing if it exists.

    Where two processes create it at the same time, the folder of the first one stays.

    Parameters
    ----------
    folder
        The folder to create. Its parent must exist.
    fill
        Writes the content into the temporary folder that it is given.
    """
    if folder.is_dir():
        return
    stage = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        fill(stage)
        try:
            stage.rename(folder)
        except OSError:
            if not folder.is_dir():
                raise
    finally:
        shutil.rmtree(stage, ignore_errors=True)
