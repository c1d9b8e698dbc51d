"""Atomic writing of files and folders."""

from __future__ import annotations

import errno
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from amb_files.temporary_folders import PREFIX, temporary_folder

MOST_LINKS = 40  # links in a row, as in Linux


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with a temporary path, then move the resulting file to `path` atomically.

    Links are followed: the file to which they lead is replaced, or created where it is missing. An existing file keeps
    its permissions and, where the system allows it, its owner. If `path` is a device, a pipe or a link to one, the
    bytes are written to it directly.

    Parameters
    ----------
    path
        The file, which is replaced if it exists. Its folder must exist.
    write
        Function that writes a file at the path that it receives.

    Raises
    ------
    OSError
        If the file cannot be written, or links lead in a circle; the error names the file.
    """
    with _naming(path):
        target = _behind_links(path)
        if is_special(target) or _is_descriptor(target):
            with temporary_folder() as folder:
                write(folder / path.name)
                with (folder / path.name).open("rb") as source, _opened(target) as stream:
                    shutil.copyfileobj(source, stream)
            return
        if target.is_file() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        with temporary_folder(target.parent) as folder:
            temporary = folder / path.name
            write(temporary)
            if target.is_file():
                _keep_permissions(target, temporary)
            temporary.replace(target)


def _behind_links(path: Path) -> Path:
    """Return the path to which links lead; it need not exist. Raises OSError if they lead in a circle."""
    followed = path
    for _ in range(MOST_LINKS):
        if _is_descriptor(followed) or not followed.is_symlink():
            return followed
        followed = followed.parent / followed.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))


def _is_descriptor(path: Path) -> bool:
    """Return whether a path is an open file of a process, as `/dev/stdout` is: others may be writing to it."""
    return path.is_symlink() and os.path.realpath(path.parent).startswith("/proc/")


def _opened(path: Path) -> BinaryIO:
    """Open a device, a pipe or an open file for writing; an open file of this process continues where it is."""
    if _is_descriptor(path) and path.name.isdecimal() and os.path.realpath(path.parent) == f"/proc/{os.getpid()}/fd":
        return os.fdopen(os.dup(int(path.name)), "wb")
    return path.open("ab" if _is_descriptor(path) else "wb")


def _keep_permissions(existing: Path, file: Path) -> None:
    """Give a file the owner, if that is allowed, and the permissions of an existing file."""
    status = existing.stat()
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(file, status.st_uid, status.st_gid)
    file.chmod(stat.S_IMODE(status.st_mode))


def plain_file(folder: Path, name: str) -> Path:
    """Return the path of a file in a folder; the name of the file was chosen by the program, not by the user.

    Raises
    ------
    OSError
        If a link of this name leads to a device or a pipe, which the user did not name.
    """
    path = folder / name
    if path.is_symlink() and is_special(path):
        raise OSError(errno.EINVAL, "it is a link to a device or a pipe", str(path))
    return path


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove the files and links of these names from a folder, if they are there."""
    for name in names:
        if plain_file(folder, name).is_file():
            (folder / name).unlink()


def write_file(path: Path, content: str | bytes) -> None:
    """Write bytes or text (as UTF-8) to a file atomically; see `write_atomically`."""
    if isinstance(content, str):
        write_atomically(path, lambda file: file.write_text(content, encoding="utf-8"))
    else:
        write_atomically(path, lambda file: file.write_bytes(content))


def create_atomically(
    folder: Path, fill: Callable[[Path], object], is_whole: Callable[[Path], bool] = Path.is_dir
) -> None:
    """Create `folder` atomically with the content that `fill` writes, unless it exists and is complete.

    If two processes create the folder at the same time, the folder of the first process remains.

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
        If the folder cannot be created; the error names the folder.
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
    """Check that a file, or a folder with these files, can be written; the check leaves nothing behind.

    Raises
    ------
    ValueError
        If the file or folder cannot be written, or if there is a folder, pipe or device at the path of one of the
        files.
    """
    try:
        target = _behind_links(path)
    except OSError as error:
        raise ValueError(f"{path} cannot be written to: {error.strerror}") from error
    if is_folder and path.is_symlink() and not path.exists():
        raise ValueError(f"{path} cannot be written to; it is a link to {target}, which does not exist")
    for name in files:
        own = path / name
        if own.is_dir() or is_special(own):
            raise ValueError(f"{own} cannot be written to; it is {'a folder' if own.is_dir() else 'no regular file'}")
    if is_folder and path.exists() and not path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a file, and the output must be a folder")
    if not is_folder and path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a folder")
    if not is_folder and path.exists() and not os.access(path, os.W_OK):
        raise ValueError(f"{path} cannot be written to: {os.strerror(errno.EACCES)}")
    if not is_folder and (is_special(target) or _is_descriptor(target)):
        return
    parent = path if is_folder else target.parent
    if not is_folder and not parent.is_dir():
        raise ValueError(f"{path} cannot be written to; there is no folder {parent}")
    existing = next(p for p in (parent, *parent.absolute().parents) if p.exists())
    try:
        with temporary_folder(existing):
            pass
    except OSError as error:
        raise ValueError(f"{path} cannot be written to: {os.strerror(error.errno or 0)} ({existing})") from error


def is_special(path: Path) -> bool:
    """Return whether a path exists but is neither a regular file nor a folder, for example a device or a pipe."""
    return path.exists() and not path.is_file() and not path.is_dir()


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Name the output in errors of the operating system that name a temporary file or no file."""
    try:
        yield
    except OSError as error:
        if error.filename is not None and PREFIX not in str(error.filename):
            raise
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
