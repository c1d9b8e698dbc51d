"""Differences of two pieces of JSON data, in words."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

MOST = 10  # differences that are reported
LONGEST = 160  # characters of a value


def list_differences(stored: Any, now: Any) -> str:
    """Return a line per difference of two pieces of JSON data, with both values."""
    lines = [f"  {at}: {_short(old)} there, {_short(new)} now" for at, old, new in _differences(stored, now)]
    return "\n".join(lines[:MOST])


def _differences(stored: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the place of each difference of two pieces of JSON data, and both values."""
    if isinstance(stored, Mapping) and isinstance(now, Mapping):
        for key in {**stored, **now}:
            yield from _differences(stored.get(key), now.get(key), f"{where}.{key}".lstrip("."))
    elif isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
        for k, (before, after) in enumerate(zip(stored, now, strict=True)):
            yield from _differences(before, after, f"{where}[{k}]")
    elif stored != now:
        yield where, stored, now


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
