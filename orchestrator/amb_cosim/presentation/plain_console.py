"""The console that commands print on."""

from __future__ import annotations

from typing import Any

from rich.console import Console


def plain_console(**options: Any) -> Console:
    """Return a console that prints every text as it is: brackets and colons in names of users are no markup."""
    return Console(markup=False, emoji=False, **options)
