"""Writes zip archives reproducibly, and unpacks them after a check."""

from __future__ import annotations

import errno
import zipfile
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path, PurePosixPath

from amb_files.atomic import write_file

NO_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip archive can store
MOST_UNPACKED = 256 * 2**20  # bytes
MOST_ENTRIES = 10_000  # unpacking takes a third of a millisecond each
LONGEST = 200  # characters of an error in a message
ENCRYPTED = 1  # in the flags of an entry
Stamp = tuple[int, int, int, int]  # of a file: its number, size, and times of its content and of its status (ns)
_COMPLETE: dict[tuple[Path, Path], dict[Path, Stamp]] = {}  # the files of archives and folders that were complete
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS, errno.EIO)  # errors unrelated to archives


def archive_of(content: Mapping[str, bytes]) -> bytes:
    """Return a zip archive of `content`, which maps the name of each entry to its bytes.

    FMUs are already compressed, so they are stored unchanged.
    """
    memory = BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, NO_TIME)
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, content[name], compresslevel=6)
    return memory.getvalue()


def write_archive(target: Path, archive: bytes) -> Path:
    """Write an archive to a file atomically, and return its path."""
    write_file(target, archive)
    return target


def unpack(archive: Path, folder: Path, name: str) -> None:
    """Unpack a zip file into a folder.

    Parameters
    ----------
    archive, folder
        The zip file, and the folder for its entries; the folder is created if it is missing.
    name
        Name of the archive in messages.

    Raises
    ------
    ValueError
        If the file is not a zip file, is damaged or encrypted, or uses an unknown compression method; if it has more
        than `MOST_ENTRIES` entries or unpacks to more than `MOST_UNPACKED` bytes; or if it has entries outside the
        folder or two different entries with the same name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    try:
        if not zipfile.is_zipfile(archive):
            raise ValueError("it is not a zip archive")
        with zipfile.ZipFile(archive) as content:
            entries = _entries(content)
            _check(content, entries)
            content.extractall(folder, entries)
    except OSError as error:
        if error.errno in DISK_ERRORS:
            raise
        raise ValueError(f"{name} cannot be unpacked: {_shortened(error)}") from error
    except Exception as error:  # each compression method raises different errors
        raise ValueError(f"{name} cannot be unpacked: {_shortened(error)}") from error


def _entries(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """Return the entries of an archive; backslashes, which some Windows tools write into names, are replaced by `/`."""
    entries = archive.infolist()
    for entry in entries:
        entry.filename = entry.filename.replace("\\", "/")
    return entries


def _check(archive: zipfile.ZipFile, entries: list[zipfile.ZipInfo]) -> None:
    """Raise ValueError if an archive contains entries that must not be unpacked."""
    size = sum(entry.file_size for entry in entries)
    if size > MOST_UNPACKED:
        raise ValueError(
            f"it unpacks to {size / 2**20:.0f} MB, which is not allowed; it must be <= {MOST_UNPACKED >> 20} MB"
        )
    if len(entries) > MOST_ENTRIES:
        raise ValueError(f"it has {len(entries)} entries, which is not allowed; it must have <= {MOST_ENTRIES}")
    entry_by_path: dict[str, zipfile.ZipInfo] = {}
    for entry in entries:
        path = PurePosixPath(entry.filename)
        if entry.flag_bits & ENCRYPTED:
            raise ValueError(f"{entry.filename} is encrypted, which is not allowed")
        if path.is_absolute() or ".." in path.parts:
            raise ValueError(f"the entry {entry.filename} is not allowed; its path must be inside the archive")
        first = entry_by_path.setdefault("/".join(path.parts), entry)  # ./x and a//x are x and a/x
        if first is not entry and archive.read(first) != archive.read(entry):
            names = dict.fromkeys((first.filename, entry.filename))
            raise ValueError(f"there are two different entries {' and '.join(names)}, which is not allowed")


def _shortened(error: Exception) -> str:
    """Return the text of an error as a short line, with `?` for unprintable characters of damaged names."""
    text = "".join(letter if letter.isprintable() else "?" for letter in str(error) or type(error).__name__)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def is_unpacked(archive: Path, folder: Path) -> bool:
    """Return whether a folder contains the entries of a zip file; sizes and checksums are compared.

    Files are not read again if they have not changed since this process found them to be complete.
    """
    seen = _COMPLETE.get((archive, folder), {})
    try:
        if seen and all(_stamp(path) == stamp for path, stamp in seen.items()):
            return True
        with zipfile.ZipFile(archive) as content:
            entries = {folder / entry.filename: entry for entry in _entries(content) if not entry.is_dir()}
        stamps = {path: _stamp(path) for path in (archive, *entries)}  # before their content is read
        is_complete = all(_is_same(entry, path.read_bytes()) for path, entry in entries.items())
    except (OSError, ValueError, zipfile.BadZipFile):
        return False
    if is_complete:
        _COMPLETE[archive, folder] = stamps
    return is_complete


def _stamp(path: Path) -> Stamp:
    status = path.stat()
    return status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def _is_same(entry: zipfile.ZipInfo, content: bytes) -> bool:
    return entry.file_size == len(content) and zlib.crc32(content) == entry.CRC
