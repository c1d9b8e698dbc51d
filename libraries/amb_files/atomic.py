"""Atomic writing of files and folders."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from amb_files.temporary_folders import PREFIX, temporary_folder


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with a temporary path, then move the result to `path` atomically.

    A link is replaced, and its target stays as it is. Devices and pipes receive the bytes directly, through links, too.

    Parameters
    ----------
    path
        The file; an existing one is replaced. Its folder must exist.
    write
        Function that writes the file at a path.

    Raises
    ------
    OSError
        If it cannot be written; the error names it.
    """
    with _naming(path):
        if is_special(path):
            with temporary_folder() as folder:
                write(folder / path.name)
                with (folder / path.name).open("rb") as source, path.open("wb") as target:
                    shutil.copyfileobj(source, target)
            return
        with temporary_folder(path.parent) as folder:
            temporary = folder / path.name
            write(temporary)
            temporary.replace(path)


def plain_file(folder: Path, name: str) -> Path:
    """Return the path of a file that a program writes into a folder under a name of its own.

    A link of this name is removed, so that a device behind it, which the user did not name, receives nothing.
    """
    path = folder / name
    if path.is_symlink():
        path.unlink()
    return path


def write_file(path: Path, content: str | bytes) -> None:
    """Write text as UTF-8, or bytes, to a file atomically; see `write_atomically`."""
    if isinstance(content, str):
        write_atomically(path, lambda file: file.write_text(content, encoding="utf-8"))
    else:
        write_atomically(path, lambda file: file.write_bytes(content))


def create_atomically(
    folder: Path, fill: Callable[[Path], object], is_whole: Callable[[Path], bool] = Path.is_dir
) -> None:
    """Create `folder` atomically with the content that `fill` writes; do nothing if it exists and is complete.

    If two processes create it at the same time, the folder of the first one remains.

    Parameters
    ----------
    folder
        The folder to create. Its parent must exist.
    fill
        Function that writes the content into a temporary folder.
    is_whole
        Function that returns whether an existing folder is complete; an incomplete one is replaced.

    Raises
    ------
    OSError
        If it cannot be created; the error names it.
    """
    if folder.is_dir() and is_whole(folder):
        return
    with _naming(folder), temporary_folder(folder.parent) as temporary:
        content = temporary / folder.name
        content.mkdir()
        fill(content)
        if folder.is_dir() and not is_whole(folder):
            folder.rename(temporary / "damaged")
        try:
            content.rename(folder)
        except OSError:
            if not folder.is_dir():
                raise


def check_writable(path: Path, is_folder: bool, files: Iterable[str] = ()) -> None:
    """Check that a file, or a folder with some files, can be written, and leave nothing behind.

    Raises
    ------
    ValueError
        If it cannot be written, or if the path of one of the files belongs to a folder, a pipe or a device.
    """
    for name in files:
        own = path / name
        if not own.is_symlink() and (own.is_dir() or is_special(own)):
            raise ValueError(f"{own} cannot be written to; it is {'a folder' if own.is_dir() else 'no regular file'}")
    if is_folder and path.exists() and not path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a file, and the output must be a folder")
    if not is_folder and path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a folder")
    if not is_folder and is_special(path):
        if not os.access(path, os.W_OK):
            raise ValueError(f"{path} cannot be written to: {os.strerror(errno.EACCES)}")
        return
    parent = path if is_folder else path.parent
    if not is_folder and not parent.is_dir():
        raise ValueError(f"{path} cannot be written to; there is no folder {parent}")
    existing = next(p for p in (parent, *parent.absolute().parents) if p.exists())
    try:
        with temporary_folder(existing):
            pass
    except OSError as error:
        raise ValueError(f"{path} cannot be written to: {os.strerror(error.errno or 0)} ({existing})") from error


def is_special(path: Path) -> bool:
    """Return whether a path exists but is neither a regular file nor a folder; it may be a device or a pipe."""
    return path.exists() and not path.is_file() and not path.is_dir()


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Name the output in errors of the operating system, instead of a temporary file or nothing."""
    try:
        yield
    except OSError as error:
        if error.filename is not None and PREFIX not in str(error.filename):
            raise
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
