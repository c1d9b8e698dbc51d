"""Zip archives with the same bytes for the same content."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

from amb_files.atomic import write_atomically

NO_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip archive can store


def write_archive(target: Path, content: Mapping[str, bytes]) -> Path:
    """Write `content` (by the names in the archive) to a zip file, whole or not at all, and return its path.

    FMUs in it, which are compressed themselves, are stored as they are.
    """

    def archive(path: Path) -> None:
        with zipfile.ZipFile(path, "w") as whole:
            for name in sorted(content):
                entry = zipfile.ZipInfo(name, NO_TIME)
                entry.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
                entry.create_system, entry.external_attr = 3, 0o100644 << 16
                whole.writestr(entry, content[name], compresslevel=6)

    write_atomically(target, archive)
    return target
