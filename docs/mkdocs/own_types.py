"""Griffe extension: parameters that a docstring documents together are documented one by one, each with its own type.

Griffe gives all of them the type and the default of the first.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

TOGETHER = re.compile(r"^(\w+(?:, \w+)+)\n((?:(?: .*)?(?:\n|\Z))+)", re.MULTILINE)  # names, and the text below them


class OwnTypes(griffe.Extension):
    """Separates names that stand together above a text."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of an object, before it is parsed."""
        if obj.docstring is not None:
            obj.docstring.value = TOGETHER.sub(_one_by_one, obj.docstring.value)


def _one_by_one(found: re.Match[str]) -> str:
    text = found[2].rstrip("\n")
    end = found[2][len(text) :]
    return "\n".join(f"{name}\n{text}" for name in found[1].split(", ")) + end
