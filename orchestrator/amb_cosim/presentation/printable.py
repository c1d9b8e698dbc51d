"""Printing of foreign text: control characters are shown, and characters that the terminal lacks are replaced.

A name in a file may contain escape sequences, which can alter the settings of the terminal or the text before them.
Everything that commands print passes through `PrintableStream` or `plain_console`; the latter's own sequences for
colours and bars bypass the stream.
"""

from __future__ import annotations

import codecs
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO, Any

# Control characters except tab and line feed; marks that turn the direction of text; halves of surrogate pairs.
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")

RESET = "\x1b[0m"  # no style; colorama, which numba loads, writes it by itself at the end
LIKE = {"µ": "u", "×": "x", "–": "-", "’": "'", "°": ""}  # instead of `?` for a sign that an encoding lacks


def _unencodable(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(LIKE.get(sign, "?") for sign in error.object[error.start : error.end]), error.end


codecs.register_error("amb_cosim.like", _unencodable)


def printable(text: str) -> str:
    """Return a text with its control characters as Python writes them, such as `\\x1b`."""
    return UNPRINTABLE.sub(lambda sign: sign[0].encode("unicode_escape").decode("ascii"), text)


class PrintableStream:
    """A text stream that writes only printable text to another stream; rich writes to that stream directly."""

    def __init__(self, stream: IO[str]) -> None:
        self.rich_proxied_file = stream

    def write(self, text: str) -> int:
        """Write a text, and return its length; `RESET` alone is passed on, because it changes no text."""
        self.rich_proxied_file.write(text if text == RESET else printable(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write several texts in sequence."""
        for line in lines:
            self.write(line)

    @property
    def buffer(self) -> Any:
        """Not available, because bytes would bypass this stream."""
        raise AttributeError("buffer")

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)


@contextmanager
def printable_streams() -> Iterator[None]:
    """Print only printable text to standard output and standard error.

    Unencodable characters are replaced according to `LIKE`, or else by `?`.
    """
    streams = sys.stdout, sys.stderr
    for stream in streams:
        with suppress(AttributeError, ValueError):  # not a stream of the system
            stream.reconfigure(errors="amb_cosim.like")  # type: ignore[union-attr]
    sys.stdout, sys.stderr = map(PrintableStream, streams)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = streams
