"""Whether a shared library in ELF format is whole; loading one that is cut off ends the process."""

from __future__ import annotations

import struct

ELF, SEGMENT_TO_LOAD = b"\x7fELF\x02\x01", 1  # 64 bits, little-endian


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
