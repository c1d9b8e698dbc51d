"""Joins macOS libraries for two processors into a universal library: a header with offsets, then both libraries."""

from __future__ import annotations

import struct

MAGIC = 0xCAFEBABE
ALIGNMENT = 14  # power of two: a page of 16 kB


def universal(slices: list[bytes]) -> bytes:
    """Join 64-bit Mach-O files, each for one processor, into a universal file; its header and table are big-endian.

    Raises
    ------
    ValueError
        If a file is not a 64-bit Mach-O file.
    """
    table, body = b"", b""
    offset = start = _aligned(8 + 20 * len(slices))
    for content in slices:
        magic, processor, variant = struct.unpack_from("<III", content)
        if magic != 0xFEEDFACF:
            raise ValueError("a universal library can only be made from 64-bit Mach-O libraries")
        table += struct.pack(">IIIII", processor, variant, offset, len(content), ALIGNMENT)
        padded = content.ljust(_aligned(len(content)), b"\0")
        body += padded
        offset += len(padded)
    header = struct.pack(">II", MAGIC, len(slices)) + table
    return header.ljust(start, b"\0") + body


def _aligned(size: int) -> int:
    return -(-size // (1 << ALIGNMENT)) << ALIGNMENT
