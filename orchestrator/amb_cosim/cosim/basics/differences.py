"""Where two pieces of JSON data differ, in words."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

MOST = 10  # differences that are told
LONGEST = 160  # characters of a value


def told_differences(there: Any, now: Any) -> str:
    """Return a line for each place where two pieces of JSON data differ, with both values; empty where none does."""
    lines = [f"  {at}: {_short(old)} there, {_short(new)} now" for at, old, new in _differences(there, now)]
    return "\n".join(lines[:MOST])


def _differences(there: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield where two pieces of JSON data differ, and both values."""
    if isinstance(there, Mapping) and isinstance(now, Mapping):
        for key in {**there, **now}:
            yield from _differences(there.get(key), now.get(key), f"{where}.{key}".lstrip("."))
    elif isinstance(there, list) and isinstance(now, list) and len(there) == len(now):
        for k, (before, after) in enumerate(zip(there, now, strict=True)):
            yield from _differences(before, after, f"{where}[{k}]")
    elif there != now:
        yield where, there, now


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
