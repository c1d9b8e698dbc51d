"""Checks the libraries of an FMU before one is loaded: a damaged one would end the process with a signal."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import fmpy

ELF, SEGMENT_TO_LOAD = b"\x7fELF\x02\x01", 1  # 64 bits, little-endian
PYTHONFMU = b"slavemodule.txt"  # a name that its library holds: the file that names the script


def check_libraries(folder: Path, identifier: str, what: str) -> None:
    """Check that an FMU has a library for this machine, whole, and what that needs when it is loaded.

    Parameters
    ----------
    folder
        Where the FMU is extracted.
    identifier
        Its model identifier.
    what
        What messages call it.

    Raises
    ------
    ValueError
        If it has none, or one that cannot be loaded.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*", identifier):
        raise ValueError(f"{what}: modelIdentifier = {identifier!r} is not allowed; it must be a name in C")
    place = folder / "binaries" / fmpy.platform
    if not (place / f"{identifier}{fmpy.sharedLibraryExtension}").is_file():
        there = sorted(path.name for path in folder.glob("binaries/*"))
        raise ValueError(f"{what} has no library {identifier} for {fmpy.platform}; it has {', '.join(there) or 'none'}")
    for library in place.glob(f"*{fmpy.sharedLibraryExtension}"):
        content = library.read_bytes()
        if not is_whole(content):
            raise ValueError(f"{what}: {library.relative_to(folder).as_posix()} is damaged: its end is missing")
        if PYTHONFMU in content:
            _check_script(folder / "resources", what)


def is_whole(library: bytes) -> bool:
    """Return whether a library in ELF format reaches to the end of its sections and of the segments that are loaded.

    Of other formats, whose loaders see to it themselves, it is not asked.
    """
    if not library.startswith(ELF):
        return True
    try:
        segments, sections = struct.unpack_from("<QQ", library, 0x20)
        segment_size, n_segments, section_size, n_sections = struct.unpack_from("<4H", library, 0x36)
        ends = [sections + section_size * n_sections]
        for k in range(n_segments):
            kind, _, offset, _, _, size = struct.unpack_from("<IIQQQQ", library, segments + k * segment_size)
            if kind == SEGMENT_TO_LOAD:
                ends.append(offset + size)
    except struct.error:
        return False
    return max(ends) <= len(library)


def _check_script(resources: Path, what: str) -> None:
    """Raise ValueError if the script is missing that PythonFMU's library loads."""
    named = resources / PYTHONFMU.decode()
    if not named.is_file():
        raise ValueError(f"{what} is damaged: resources/{named.name} is missing, which names its script")
    script = resources / f"{named.read_text(encoding='utf-8', errors='replace').strip()}.py"
    if not script.is_file():
        raise ValueError(f"{what} is damaged: its script resources/{script.name} is missing")
