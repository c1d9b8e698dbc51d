"""Finds the code blocks of a page and runs them in a folder.

A block whose first line is a comment with a file's name is that file. Of the others Python runs in one namespace for
the page, sh in bash, TOML is read, and text after a command is part of what that prints. A title that begins with
`Needs` names what a block takes besides this package; one that begins with `Part of` is no program. Commands of the
README with a marker are run by `.ci/run`.
"""

import os
import re
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from command_line import run_program
from markdown_it import MarkdownIt

TITLE = re.compile(r'title="(Needs|Part of) ([^"]+)"')
FILE_NAME = re.compile(r"# ([\w./-]+\.(?:toml|py))\b")
MARKER = "<!-- command:"
LANGUAGES = ("python", "sh", "toml", "text")
SECONDS = 900


class Block(NamedTuple):
    """A fenced block: its language, first line in the page, content, and what it needs or is a part of."""

    language: str
    line: int
    code: str
    needs: str | None
    part_of: str | None

    @property
    def file_name(self) -> str | None:
        """Return the name of the file that the block contains, if it states one."""
        result = FILE_NAME.match(self.code)
        return result[1] if result else None


def blocks_of(page: Path) -> list[Block]:
    """Return the fenced blocks of a page that have a language, without those below a marker of `.ci/run`."""
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    blocks = []
    for before, token in zip([None, *tokens], tokens, strict=False):
        marked = before is not None and before.type == "html_block" and before.content.startswith(MARKER)
        if token.type != "fence" or not token.info.strip() or marked:
            continue
        language, title = token.info.split()[0], TITLE.search(token.info)
        kind, what = title.groups() if title else (None, None)
        line = token.map[0] + 1 if token.map else 0
        needs, part_of = (what if kind == word else None for word in ("Needs", "Part of"))
        blocks.append(Block(language, line, token.content, needs, part_of))
    return blocks


def example_of(package: str, language: str = "python") -> str:
    """Return the only block of a language in the README of a package."""
    page = Path(find_spec(package).origin).with_name("README.md")
    (code,) = (block.code for block in blocks_of(page) if block.language == language)
    return code


def run_blocks(blocks: list[Block], page: Path, folder: Path) -> None:
    """Run blocks one after another in `folder`, which must be the working folder too."""
    namespace: dict[str, Any] = {"__name__": "__main__"}
    printed = ""
    for block in blocks:
        if block.file_name:
            file = folder / block.file_name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.code, encoding="utf-8")
        elif block.language == "python":
            exec(compile("\n" * block.line + block.code, str(page), "exec"), namespace)
        elif block.language == "sh":
            printed = run_shell(block, page, folder)
        elif block.language == "toml":
            tomllib.loads(block.code)
        elif block.language == "text":
            missing = [line for line in block.code.splitlines() if printed and line not in printed]
            assert missing == [], f"{page}:{block.line}: not in what the command printed:\n{printed}"
        else:
            raise AssertionError(f"{page}:{block.line}: nothing runs {block.language}; allowed are {LANGUAGES}")


def run_shell(block: Block, page: Path, folder: Path) -> str:
    """Run a block of shell commands with this Python's programs first; return what it printed."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path}
    done = run_program("bash", "-euc", block.code, cwd=folder, env=environment, timeout=SECONDS, code=None)
    printed = f"{done.stdout}\n{done.stderr}"
    assert done.returncode == 0, f"{page}:{block.line}: exit code {done.returncode}\n{printed}"
    return printed
