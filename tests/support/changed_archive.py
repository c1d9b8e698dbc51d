"""Copies of archives in which some entries are others."""

import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path


def changed_archive(
    source: Path,
    target: Path,
    entries: Mapping[str, str | bytes | None],
    change: Callable[[str, bytes], bytes] = lambda _, content: content,
) -> Path:
    """Write `target`, with these entries, or without those that are None; `change(name, content)` changes others."""
    with zipfile.ZipFile(source) as old:
        contents = {name: change(name, old.read(name)) for name in old.namelist()} | dict(entries)
    with zipfile.ZipFile(target, "w") as new:
        for name, content in contents.items():
            if content is not None:
                new.writestr(zipfile.ZipInfo(name), content)  # the same bytes at any time
    return target


def with_text(source: Path, target: Path, entry: str, old: str, new: str) -> Path:
    """Write `target`, with the first `old` in one entry replaced by `new`."""
    with zipfile.ZipFile(source) as archive:
        text = archive.read(entry).decode()
    assert old in text, old
    return changed_archive(source, target, {entry: text.replace(old, new, 1)})
