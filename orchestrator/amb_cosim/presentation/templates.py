"""Page templates in which an undefined name is an error."""

from __future__ import annotations

from collections.abc import Callable

from jinja2 import Environment, PackageLoader, StrictUndefined


def templates_of(package: str, folder: str, finalize: Callable[[object], object] | None = None) -> Environment:
    """Return the templates in a folder of a package; they apply `finalize` to each value, then escape the result."""
    return Environment(
        finalize=finalize,
        loader=PackageLoader(package, folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
