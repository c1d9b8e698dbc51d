"""Differences between two pieces of JSON data, in words."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from amb_files.toml import read_toml

MOST = 10  # differences that are reported
LARGEST = 10_000  # size of an array that is compared number by number
LONGEST = 160  # characters of a value


def list_differences(stored: Any, now: Any) -> str:
    """Return a line for each difference between two pieces of JSON data, with both values."""
    lines = [f"  {at}: {_short(old)} then, {_short(new)} now" for at, old, new in _differences(stored, now)]
    return "\n".join(lines[:MOST])


def described(source: Any) -> tuple[str, Any]:
    """Return the name and the content (JSON data) of a file or a dataclass; for a file other than TOML, its digest."""
    if not isinstance(source, str | Path):
        content = json.dumps(asdict(source), default=_as_data)
        return f"{type(source).__name__} of Python", json.loads(content)
    file = Path(source)
    if file.suffix == ".toml":
        return file.name, json.loads(json.dumps(read_toml(file, f"file {file}"), default=str))
    with file.open("rb") as opened:
        return file.name, hashlib.file_digest(opened, "sha256").hexdigest()


def _as_data(value: Any) -> Any:
    """Return an array as lists, or as its digest if it is large; return any other object as text."""
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size <= LARGEST else hashlib.sha256(value.tobytes()).hexdigest()
    return repr(value)


def list_other_sources(stored: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return lines on the files and objects (`described`, by kind) that differ, and on how their content differs.

    Kinds that only one of the two mappings contains are not listed.
    """
    lines = []
    for kind in stored.keys() & now.keys():
        (name, old), (new_name, new) = stored[kind], now[kind]
        if old != new:
            lines.append(f"  {kind}: {name if name == new_name else f'{name} then, {new_name} now'}, which differ")
            inner = list_differences(old, new) if not isinstance(old, str) and not isinstance(new, str) else ""
            lines += [f"  {line}" for line in inner.splitlines()]
    return "\n".join(lines)


def _differences(stored: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the path and both values of each difference between two pieces of JSON data."""
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
