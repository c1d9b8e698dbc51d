"""Each command and study has a description that `--help` shows in full."""

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator

import click
import pytest
from click.testing import CliRunner

from amb_cosim.commands.cli import main
from amb_files.pack_file import default
from amb_files.packs import packs
from tests.support.messages import assert_names

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


def test_examples_and_defaults_of_help_have_no_speed_in_rad_per_s():
    texts = {path: command.get_help(context) for path, command, context in helps(main)}
    in_quotes_or_default = re.compile(r"'[^'\n]*rad/s|\[default: [^\]]*rad/s")
    assert [path for path, text in texts.items() if in_quotes_or_default.search(text)] == []


def helps(command: click.Command, path: str = "amb-cosim") -> Iterator[tuple[str, click.Command, click.Context]]:
    context = click.Context(command, info_name=path)
    yield path, command, context
    for name in command.list_commands(context) if isinstance(command, click.Group) else ():
        below = command.get_command(context, name)
        assert below is not None
        yield from helps(below, f"{path} {name}")


HELPS = {path: (command, context.get_help()) for path, command, context in helps(main)}  # type: ignore[arg-type]


@pytest.mark.parametrize("path", HELPS)
def test_each_help_has_two_examples_that_its_command_accepts(path: str) -> None:
    """Files of examples may be missing, so commands are parsed and not run."""
    command, text = HELPS[path]
    lines = [line.strip() for line in text.partition("Examples:")[2].splitlines() if line.strip()]
    assert len(lines) >= 2
    assert max(map(len, text.splitlines())) <= 80
    assert not re.search(r"^  \S+ .*\.\.\.$", text, re.MULTILINE), "a list of commands cuts a description"
    for line in lines:
        assert line.startswith(path if not isinstance(command, click.Group) else "amb-cosim")
        parsed: click.Command = main  # type: ignore[assignment]
        arguments = shlex.split(line)[1:]
        while isinstance(parsed, click.Group):
            below = parsed.get_command(click.Context(parsed), arguments.pop(0))
            assert below is not None, line
            parsed = below
        parsed.make_context(path, arguments)


def test_help_of_rotors_names_the_default_rotor() -> None:
    with_rotor = [text for command, text in HELPS.values() if any(p.name == "rotor" for p in command.params)]
    named = [" ".join(text.split()) for text in with_rotor if "Packaged rotor" in " ".join(text.split())]
    assert len(named) > 10
    assert all(f"{default('rotor')}." in text for text in named)


@pytest.mark.parametrize(
    ("study", "levitated"), [("campbell", "poles"), ("modes", "poles"), ("receptance", "response")]
)
def test_a_study_of_a_rotor_alone_names_that_of_the_levitated_machine(study: str, levitated: str) -> None:
    ended = CliRunner().invoke(main, ["study", study, "my_scenario"])  # type: ignore[arg-type]
    assert ended.exit_code == 2
    assert_names(ended.output, f"study {levitated} my_scenario", "--rotor")


def test_no_heading_of_a_help_names_a_python_package() -> None:
    headings = [line.strip() for _, text in HELPS.values() for line in text.splitlines() if line[:1].isalpha()]
    assert "Options:" in headings
    modules = re.compile(r"\b[a-z]+_[a-z_]+\b")
    named = {name for heading in headings if heading.endswith(":") for name in modules.findall(heading)}
    assert named <= packs().keys()
