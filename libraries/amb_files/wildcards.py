"""Names with characters that stand for others: `*` for any, `?` for any one, `[xy]` for one of these.

Brackets with numbers are the index of an array, and stand for themselves: `u[2]`, `gains[*,1]`.
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterable
from functools import lru_cache

_INDEX = re.compile(r"\[(?=[\d,*?]*\])")


def is_pattern(name: str) -> bool:
    """Return whether a name has characters that stand for others."""
    return bool(set("*?[") & set(_INDEX.sub("", name)))


def matches(name: str, pattern: str) -> bool:
    """Return whether a name is what a pattern stands for."""
    return _compiled(pattern).match(name) is not None


def matching_names(names: Iterable[str], pattern: str) -> list[str]:
    """Return the names that a pattern stands for, in their order."""
    match = _compiled(pattern).match
    return [name for name in names if match(name)]


@lru_cache(maxsize=1024)
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(fnmatch.translate(_INDEX.sub("[[]", pattern)))
