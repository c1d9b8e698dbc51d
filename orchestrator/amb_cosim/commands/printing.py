"""Printing of results, as JSON or as tables and lines."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from amb_files.atomic import check_writable

if TYPE_CHECKING:
    from amb_cosim.presentation.text_tables import TextBlock
    from rotor_analysis.rotor_file import RotorSource


PICTURES = (".png", ".pdf", ".svg")
ENGINES = "fmi_export.building.native.engines"  # logger of what is compiled


class Printed(Protocol):
    """A result that can be printed as JSON or as text."""

    def as_dict(self) -> dict[str, Any]:
        """Return the data for JSON, under keys that include their units."""

    def text(self) -> list[TextBlock]:
        """Return the tables and lines that describe the result."""


def check_picture(path: Path, others: Sequence[str] = (), pictures: Sequence[str] = PICTURES) -> None:
    """Raise ValueError unless the path can be written, and its suffix is that of a picture or one of `others`."""
    allowed = (*pictures, *others)
    if path.suffix.lower() not in allowed:
        raise ValueError(f"{path} is not allowed; its name must end with {', '.join(allowed)}")
    check_writable(path, is_folder=False)


def show(data: dict[str, Any], as_text: Callable[[dict[str, Any]], Iterable[TextBlock]], as_json: bool) -> None:
    """Print data as JSON, or the tables and lines that `as_text` returns for it."""
    from amb_cosim.presentation.text_tables import print_parts

    if as_json:
        click.echo(json.dumps(data, indent=2, allow_nan=False))
    else:
        print_parts(as_text(data))


def print_result(result: Printed, as_json: bool) -> None:
    """Print a result as JSON, or as tables and lines."""
    show(result.as_dict(), lambda _: result.text(), as_json)


@contextmanager
def compilations_shown() -> Iterator[None]:
    """Print a line to standard error for each model and platform when it is compiled, which takes up to minutes."""
    log, handler = logging.getLogger(ENGINES), logging.Handler()
    handler.emit = lambda record: click.echo(record.getMessage(), err=True)  # type: ignore[method-assign]
    level = log.level
    log.setLevel(logging.INFO)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


def warn_of_sizes(rotor: RotorSource) -> tuple[str, ...]:
    """Print warnings of a rotor's implausible sizes to standard error, and return them; do nothing without a rotor.

    Commands call this before they compute with the rotor. A prepared run includes these warnings in its own list.
    """
    if rotor is None:
        return ()
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.presentation.text_tables import show_warnings
    from rotor_analysis.implausible_sizes import implausible_sizes
    from rotor_analysis.rotor_file import load_rotor

    sentences = implausible_sizes(load_rotor(rotor))
    show_warnings(sentences, plain_console(stderr=True))
    return sentences
