"""Docstrings and messages of Python files as passages."""

from __future__ import annotations

import ast
import re
from functools import cache
from typing import TYPE_CHECKING

from prose import Passage

if TYPE_CHECKING:
    from pathlib import Path

WORDS = re.compile(r"[A-Za-z]{2,}")
VALUE = "{}"  # in place of a value in a message


@cache
def passages_of_source(file: Path) -> tuple[Passage, ...]:
    """Return docstrings, and strings of three words or more, with their lines; comments are not checked."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    parts = {part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    return tuple(
        Passage("p", node.lineno, " ".join(paragraph.split()))
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant | ast.JoinedStr) and node not in parts
        for paragraph in re.split(r"\n\s*\n|\n\s*-{3,}\n", _text(node))
        if len(WORDS.findall(paragraph)) >= 3 and " " in paragraph.strip()
    )


def _text(node: ast.Constant | ast.JoinedStr) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    return "".join(str(part.value) if isinstance(part, ast.Constant) else VALUE for part in node.values)
