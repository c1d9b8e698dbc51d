"""The prose of a Markdown page: its paragraphs, headings and table cells, without code, equations and links."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt
from markdown_it.token import Token

MARKDOWN = MarkdownIt().enable("table")
EQUATION = re.compile(r"\$\$.*?\$\$", re.DOTALL)
FORMULA = re.compile(r"\$[^$]+\$")
CODE = "`_`"  # stands for code and formulas in a passage
END = re.compile(r"(?<=[.!?])\s+(?=[A-Z`\"(])")


class Passage(NamedTuple):
    """A paragraph, heading or table cell: its kind, first line in the page, and text."""

    kind: str
    line: int
    text: str

    @property
    def sentences(self) -> list[str]:
        return END.split(self.text)


def passages_of(page: Path) -> Iterator[Passage]:
    """Yield the passages of a page in order."""
    text = EQUATION.sub(lambda match: "\n" * match[0].count("\n"), page.read_text(encoding="utf-8"))
    open_tokens: list[Token] = []
    for token in MARKDOWN.parse(text):
        if token.nesting > 0:
            open_tokens.append(token)
        elif token.nesting < 0:
            open_tokens.pop()
        elif token.type == "inline":
            line = next(outer.map[0] for outer in reversed(open_tokens) if outer.map) + 1
            yield Passage(open_tokens[-1].tag, line, FORMULA.sub(CODE, "".join(map(_shown, token.children or []))))


def _shown(token: Token) -> str:
    if token.type in ("softbreak", "hardbreak"):
        return " "
    return {"text": token.content, "code_inline": CODE}.get(token.type, "")
