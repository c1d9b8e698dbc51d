"""The cache of built and unpacked FMUs: the user's folder or, if this is not writable, a folder of this process.

If the cache exceeds `LIMIT` bytes, a new entry displaces the least recently used ones, except those used within the
last day. The size of the cache is measured at most once an hour, because this takes a second for thousands of entries.
Only folders whose names belong to this cache are removed.
"""

from __future__ import annotations

import hashlib
import os
import re
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from amb_files.archive import is_unpacked, unpack
from amb_files.atomic import create_atomically
from amb_files.temporary_folders import temporary_folder
from amb_files.user_cache import user_cache

LONGEST_NAME = 60  # characters of a file's name that the name of its folder takes over

LIMIT = 2 * 2**30  # bytes
MEASURED = ".measured"  # file of the cache: its time is that of the last measurement
BETWEEN_MEASUREMENTS = 3600.0  # s
IN_USE = 24 * 3600.0  # s; an entry used within this time may still be loaded by a process
COMPILED = ("engines", "loops")  # small, and minutes to compile: removed only with everything else, `over` = 0
ENCODED = re.compile(r"[^A-Za-z0-9._-]")  # characters that a URI encodes, such as %20; some FMUs do not decode them
LOADED = ".loaded"  # suffix of the mark of an FMU that has been loaded
ENTRY = re.compile(r".+-[0-9a-f]{32}")  # names of all other entries


@dataclass(frozen=True)
class CacheEntry:
    """An entry of the cache: its path, its size (bytes), and the time of its last use (s since 1970)."""

    path: Path
    size: int
    used: float


def unpacked(archive: Path, name: str) -> Path:
    """Return the cache folder with the unpacked archive; messages use `name` for the archive.

    The name of the folder consists of the archive's name, without characters that a URI encodes, and a digest of the
    archive. The folder is recreated if its content differs from the archive.

    Raises
    ------
    ValueError
        If the archive cannot be read or unpacked.
    """
    try:
        digest = hashlib.sha256(archive.read_bytes()).hexdigest()[:32]
    except OSError as error:
        raise ValueError(f"{name} cannot be read: {error.strerror or error}") from error
    home = user_cache() / f"{ENCODED.sub('_', archive.stem)[:LONGEST_NAME]}-{digest}"
    is_new = not home.is_dir()
    create_atomically(home, lambda folder: unpack(archive, folder, name), lambda folder: is_unpacked(archive, folder))
    note_use(home, is_new)
    return home


def is_first_loading(home: Path) -> bool:
    """Return whether an unpacked FMU has not been loaded here before, and mark it as loaded.

    The mark is a file beside the FMU's folder, where no unpacked archive can create it.
    """
    try:
        _mark(home).touch(exist_ok=False)
    except FileExistsError:
        return False
    except OSError:  # another user's cache
        pass
    return True


def note_use(home: Path, is_new: bool) -> None:
    """Mark a folder of the cache as used; if the folder is new, it may displace others."""
    with suppress(OSError):  # another user's cache, or a folder that has gone since
        os.utime(home)
        if is_new and _is_due(user_cache() / MEASURED):
            remove_entries(over=LIMIT, unused_for=IN_USE)


def cache_entries() -> list[CacheEntry]:
    """Return the entries of the cache, least recently used first."""
    paths = [path for path in user_cache().iterdir() if path.is_dir()]
    entries = [_entry(path) for path in paths if ENTRY.fullmatch(path.name) or path.name in COMPILED]
    return sorted(entries, key=lambda entry: entry.used)


def remove_entries(over: int = 0, unused_for: float = 0.0) -> list[CacheEntry]:
    """Remove the least recently used entries until the cache has at most `over` bytes; return the removed entries.

    Entries used within the last `unused_for` seconds are kept.
    """
    entries, removed = [entry for entry in cache_entries() if not over or entry.path.name not in COMPILED], []
    size, now = sum(entry.size for entry in entries), time.time()
    for entry in entries:
        if (over and size <= over) or now - entry.used < unused_for:
            break
        with temporary_folder(user_cache()) as folder, suppress(OSError):  # another process was faster
            entry.path.rename(folder / entry.path.name)  # at once, so that no process sees part of it
            removed.append(entry)
            _mark(entry.path).unlink(missing_ok=True)
        size -= entry.size
    return removed


def _mark(home: Path) -> Path:
    return home.with_name(f"{home.name}{LOADED}")


def _is_due(measured: Path) -> bool:
    """Return whether it is time to measure the cache again; if so, the period until the next measurement starts now."""
    with suppress(OSError):  # never measured
        if abs(time.time() - measured.stat().st_mtime) < BETWEEN_MEASUREMENTS:
            return False
    measured.touch()
    return True


def _entry(path: Path) -> CacheEntry:
    size, used = 0, 0.0
    with suppress(OSError):
        used = path.stat().st_mtime
        size = sum(file.lstat().st_size for file in path.rglob("*") if not file.is_dir())
    return CacheEntry(path, size, used)
