"""Damage as disks and copies do it: bytes that are cut off, zeros among them, bits that are turned."""

from __future__ import annotations

import random


def damaged(content: bytes, chance: random.Random) -> bytes:
    """The content cut, emptied, with zeros in it or with some bits turned."""
    at, kind = chance.randrange(max(len(content), 1)), chance.randrange(6)
    if kind == 0:
        return content[:at]
    if kind == 1 or not content:
        return b""
    if kind == 2:
        end = min(at + 4096, len(content))
        return content[:at] + bytes(end - at) + content[end:]
    changed = bytearray(content)
    for _ in range(chance.choice((1, 1, 10))):
        changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)
