"""Each command and study is described in a line that `--help` shows whole."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

import click
import pytest
from click.testing import CliRunner

from amb_cosim.commands.cli import main

WIDTH, LONGEST = 78, 60  # characters; click leaves two of a terminal of 80


def _groups(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    yield path
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from _groups(command, (*path, name))


@pytest.mark.parametrize("path", [*_groups(main)], ids=" ".join)
def test_help_shows_each_command_in_one_whole_line(path):
    group: click.Command = main
    for name in path:
        group = group.get_command(click.Context(group), name)
    displayed = CliRunner().invoke(main, [*path, "--help"], terminal_width=WIDTH).output
    listed = displayed[displayed.index("--help") :]  # the last of the options; the groups of commands follow
    context = click.Context(group)
    texts = {name: group.get_command(context, name).get_short_help_str(1000) for name in group.list_commands(context)}
    assert [name for name, text in texts.items() if not text[:1].isupper() or len(text) >= LONGEST] == []
    assert "..." not in listed
    assert [name for name, text in texts.items() if text not in listed] == []


def test_commands_are_listed_in_groups_and_those_of_a_package_under_its_name():
    shown = CliRunner().invoke(main, ["--help"], terminal_width=WIDTH).output
    headings = [line[:-1] for line in shown.splitlines() if line.endswith(":") and not line.startswith(" ")]
    own = ["Run", "Design and judge", "FMUs and other tools", "Housekeeping"]
    assert headings[:6] == ["Options", *own, "Package source_check"]
    assert shown.index("Package source_check:") < shown.index("  report ")


ALL_HELP = """
import json
import click
from amb_cosim.commands.cli import main

def texts(command, path):
    context = click.Context(command, info_name=path)
    yield path, command.get_help(context)
    for name in getattr(command, "list_commands", lambda _: [])(context):
        yield from texts(command.get_command(context, name), f"{path} {name}")

print(json.dumps(dict(texts(main, "amb-cosim"))))
"""


def test_help_is_the_same_without_docstrings():
    plain, optimised = (
        json.loads(subprocess.run([sys.executable, *flag, "-c", ALL_HELP], capture_output=True, check=True).stdout)
        for flag in ([], ["-OO"])
    )
    assert len(plain) > 40
    assert optimised == plain
