"""Each command and study has a description that `--help` shows in full."""

from __future__ import annotations

import json
import subprocess
import sys

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
