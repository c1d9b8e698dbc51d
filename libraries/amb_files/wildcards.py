"""Names with wildcards: `*` for any characters, `?` for any single character, `[xy]` for x or y.

Brackets that contain numbers are array indices, such as `u[2]` and `gains[*,1]`, and are taken literally.
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterable
from functools import lru_cache

_INDEX = re.compile(r"\[(?=[\d,*?]*\])")


def is_pattern(name: str) -> bool:
    """Return whether a name contains wildcards."""
    return bool(set("*?[") & set(_INDEX.sub("", name)))


def matches(name: str, pattern: str) -> bool:
    """Return whether a name matches a pattern."""
    return _compiled(pattern).match(name) is not None


def matching_names(names: Iterable[str], pattern: str) -> list[str]:
    """Return the names that match a pattern, in the given order.

    Examples
    --------
    >>> matching_names(["left.k_b", "right.k_b", "left.c_b"], "*.k_b")
    ['left.k_b', 'right.k_b']
    >>> matching_names(["u[1]", "u[2]"], "u[2]")
    ['u[2]']
    """
    match = _compiled(pattern).match
    return [name for name in names if match(name)]


@lru_cache(maxsize=1024)
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(fnmatch.translate(_INDEX.sub("[[]", pattern)))
