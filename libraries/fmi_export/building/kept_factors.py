"""Factors between units that pint was asked for, kept in the user's cache: another start needs no pint for them."""

from __future__ import annotations

import importlib.metadata
import json
import math
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from amb_files.atomic import write_atomically
from amb_files.user_cache import user_cache

FILE = "unit_factors.json"
MOST = 500  # factors that are kept


def kept_factor(given: str, unit: str) -> float | None:
    """Return one of the first unit in the second, to the last bit as pint has it; None if it is not kept."""
    return _kept().get(f"{given} {unit}")


def keep_factor(given: str, unit: str, factor: float) -> None:
    """Keep the factor between two units; nothing is kept where the cache cannot be written."""
    factors = _kept()
    factors[f"{given} {unit}"] = factor
    content = {"pint": _version(), "factors": {name: value.hex() for name, value in [*factors.items()][-MOST:]}}
    with suppress(OSError):
        _path().parent.mkdir(parents=True, exist_ok=True)
        write_atomically(_path(), lambda path: path.write_text(json.dumps(content, indent=1), encoding="utf-8"))


@cache
def _kept() -> dict[str, float]:
    """Return what is kept by this version of pint; nothing of a file that is damaged or of another version."""
    try:
        content: dict[str, Any] = json.loads(_path().read_text(encoding="utf-8"))
        factors = {str(name): float.fromhex(text) for name, text in content["factors"].items()}
        is_right = content["pint"] == _version() and all(math.isfinite(value) for value in factors.values())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
    return factors if is_right else {}


def _path() -> Path:
    return user_cache() / FILE


def _version() -> str:
    return importlib.metadata.version("pint")
