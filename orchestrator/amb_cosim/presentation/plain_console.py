"""The console to which commands print."""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO, Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from amb_cosim.presentation.printable import printable


class PrintableConsole(Console):
    """A console that sends no control characters to the terminal except those that it adds itself."""

    @property
    def file(self) -> IO[str]:
        """The stream behind a `PrintableStream`, even if a progress bar has placed another stream in front of it."""
        stream = super().file
        inner: IO[str] = getattr(stream, "rich_proxied_file", stream)
        return inner

    @file.setter
    def file(self, stream: IO[str]) -> None:
        Console.file.fset(self, stream)  # type: ignore[attr-defined]

    def render_str(self, text: str, **options: Any) -> Text:
        """Show the control characters in a text before its width is measured and its lines are wrapped."""
        return super().render_str(printable(text), **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield the parts of a text or table with control characters shown."""
        for part in super().render(renderable, options):
            yield part if part.control else Segment(printable(part.text), part.style)


def plain_console(**options: Any) -> Console:
    """Return a console that prints text unchanged, because brackets and colons in users' names are not markup."""
    return PrintableConsole(markup=False, emoji=False, **options)
