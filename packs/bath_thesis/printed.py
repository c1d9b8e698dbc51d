"""Numbers printed in the thesis, from the files `printed_NAME.toml` next to this module."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any


def table_of(name: str) -> dict[str, Any]:
    """Return the tables of `printed_NAME.toml`, which are printed frequencies (rad/s) or the printed H at 10 Hz."""
    tables = tomllib.loads((Path(__file__).parent / f"printed_{name}.toml").read_text(encoding="utf-8"))
    return {key: table for key, table in tables.items() if key != "source"}
