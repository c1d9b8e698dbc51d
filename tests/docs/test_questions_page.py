"""The page of questions has every command, study, public function and kind of file, and each command once."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

import amb_cosim
from amb_cosim.commands.cli import main

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reference/questions.md").read_text(encoding="utf-8")
REMOVED = (DOCS / "reference/removed.md").read_text(encoding="utf-8")
CODE = re.compile(r"`([^`]+)`")


def _commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[str]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from _commands(command, (*path, name))
        else:
            yield " ".join((*path, name))


def test_every_command_answers_one_question():
    cells = [row.split("|")[3] for row in PAGE.splitlines() if row.count("|") >= 4 and "`" in row.split("|")[3]]
    named = Counter(name for cell in cells for name in CODE.findall(cell) if "--" not in name)
    assert named - Counter(["run"]) == Counter(_commands(main))  # `run` also refuses what does not fit


def _is_raised(name: str) -> bool:
    """Whether a name is that of an error or a warning, which answers no question."""
    value = getattr(amb_cosim, name)
    return isinstance(value, type) and issubclass(value, BaseException)


@pytest.mark.parametrize("name", [name for name in dir(amb_cosim) if not _is_raised(name)])
def test_every_public_function_is_on_the_page(name):
    assert name == "studies" or f"`{name}`" in PAGE


def test_every_kind_of_file_is_on_the_page():
    files = {file.name for file in (DOCS / "reference").glob("*_file.md")}
    assert files == {*re.findall(r"\((\w+_file\.md)\)", PAGE)}


def test_former_commands_are_those_that_the_command_line_refuses():
    former = [row.split("|")[1].strip().replace("`", "") for row in REMOVED.splitlines() if row.count("|") == 3]
    assert {*main.former} <= {name.split()[0] for name in former}
