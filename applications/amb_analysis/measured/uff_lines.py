"""Lines of universal files as pyuff can read them: without trailing blanks, and with one kind of line ending."""

from __future__ import annotations

import re

BINARY_HEAD = re.compile(rb"^ {4}58b([^\n]*)\n", re.MULTILINE | re.IGNORECASE)
LINES_OF_TEXT, BYTES = slice(12, 24), slice(24, 36)  # columns of a head after its type
HEAD = 11  # lines of text of a binary set, if it does not state their number
END_OF_SET = re.compile(rb"(?:\r?\n)? {4}-1[ \t]*\r?(?=\n|\Z)")


def unpadded(content: bytes) -> bytes:
    """Return a file without trailing blanks, which pyuff mistakes for numbers, and with one kind of line ending.

    Binary numbers are left as they are. The header of a set states how many lines of text it has, and how many bytes of
    binary numbers follow the text. The numbers end at the first end-of-set line after this number of bytes.
    """
    parts, at = [], 0
    for head in BINARY_HEAD.finditer(content):
        if head.start() < at:
            continue  # bytes among numbers that look like a head
        fields = (head[1][columns].strip() for columns in (LINES_OF_TEXT, BYTES))
        lines, size = (int(field) if field.isdigit() else 0 for field in fields)
        begin = head.end()
        for _ in range(min(lines, HEAD) or HEAD):
            begin = content.find(b"\n", begin) + 1 or len(content)
        end = END_OF_SET.search(content, begin + size) or END_OF_SET.search(content, begin)
        stop = len(content) if end is None else end.start()
        parts += [_stripped(content[at:begin]), content[begin:stop]]
        at = stop
    return b"".join([*parts, _stripped(content[at:])])


def _stripped(text: bytes) -> bytes:
    return re.sub(rb"[ \t]+(?=[\r\n]|\Z)", b"", text).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
