"""What commands print: names from files cannot control a terminal, and a sign that it lacks does not end a command."""

import io
import os
import re
import subprocess
import sys

import click
import pytest
from command_line import COMMAND

from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.printable import printable, printable_streams
from amb_cosim.presentation.text_tables import text_table

EVIL = "\x1b]0;pwn\x07a\rb\x08c\x9bd\u202ee"
SHOWN = r"\x1b]0;pwn\x07a\rb\x08c\x9bd\u202ee"


def test_control_characters_are_shown():
    assert printable(EVIL) == SHOWN
    assert printable("a\tµ Ω\nb") == "a\tµ Ω\nb"


@pytest.mark.parametrize("is_terminal", [False, True])
def test_a_console_sends_no_control_characters_of_texts(is_terminal):
    file = io.StringIO()
    console = plain_console(file=file, force_terminal=is_terminal, width=100)
    console.print(EVIL, highlight=False)
    console.print(text_table(EVIL, [EVIL, "x"], [(EVIL, "1")]))
    sent = file.getvalue()
    assert sent.count(SHOWN) == 4
    assert "\x1b]" not in sent
    assert not set("\x07\r\x08\x9b\u202e") & set(sent)
    assert ("\x1b[" in sent) == is_terminal  # its own styles


@pytest.mark.parametrize("is_terminal", [False, True])
def test_control_characters_cut_no_line_short(is_terminal):
    """Shown, they are wider than the terminal counts them, so that the end of a full line would be lost."""
    file = io.StringIO()
    console = plain_console(file=file, force_terminal=is_terminal, width=40)
    console.print("\x1b]0;pwn\x07 is sampled every 5e-05 s, not 5 s", highlight=False)
    console.print(text_table("", ["machine", "step"], [("\x1b]0;pwn\x07", "is every 5e-05 s")]))
    words = re.sub(r"\x1b\[[0-9;]*m", "", file.getvalue()).split()
    assert words.count("5e-05") == 2
    assert words.count(r"\x1b]0;pwn\x07") == 2


def test_the_reset_that_colorama_sends_at_the_end_is_not_shown(capsys):
    with printable_streams():
        at_exit = sys.stdout
    at_exit.write("\x1b[0m")
    assert capsys.readouterr().out == "\x1b[0m"


def test_other_prints_of_a_command_send_none_either(capsys):
    with printable_streams():
        click.echo(EVIL)
        print(EVIL, file=sys.stderr)
    printed = capsys.readouterr()
    assert printed.out == printed.err == f"{SHOWN}\n"


def test_messages_show_the_name_of_a_file_and_are_short(runner, tmp_path):
    (tmp_path / "rotor.toml").write_text('name = "a"\n"\\u001b]0;pwn\\u0007" = 1\n' + "x" * 20_000 + " = 1\n")
    refused = runner("rotor", "show", "rotor.toml")
    assert refused.exit_code == 2
    assert r"\x1b]0;pwn\x07" in refused.stderr
    assert "\x1b" not in refused.stderr
    assert len(refused.stderr) < 3000


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("encoding", ["ascii", "koi8-r", "cp437", "utf-8"])
def test_a_terminal_of_any_encoding_shows_a_bar_and_what_it_can(encoding, tmp_path):
    program = """
from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.printable import printable_streams
with printable_streams(), plain_console(stderr=True).status("computing \\x1b]0;pwn\\x07"):
    plain_console().print("13.7 µm of 3 ☃")
"""
    ours, theirs = os.openpty()
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "TERM": "xterm"}
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=theirs, stderr=theirs, env=environment) as process:
        os.close(theirs)
        sent = b""
        try:
            while part := os.read(ours, 4096):
                sent += part
        except OSError:  # the other end is closed
            pass
    os.close(ours)
    assert process.returncode == 0
    assert b"Traceback" not in sent
    shown = re.sub(rb"\x1b\[[0-9;]*m", b"", sent).decode(encoding)
    assert (
        f"13.7 {'u' if encoding in ('ascii', 'koi8-r') else 'µ'}m of 3 {'☃' if encoding == 'utf-8' else '?'}" in shown
    )
    assert b"\x1b[?25l" in sent  # the bar hides the cursor
    assert rb"\x1b[" not in sent  # its sequences are sent, not shown
    assert b"\x1b]0;" not in sent


def test_commands_print_only_printable_text(tmp_path):
    (tmp_path / "rotor.toml").write_text('"\\u001b]0;pwn\\u0007" = 1\n')
    done = subprocess.run([*COMMAND, "rotor", "show", "rotor.toml"], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 2
    assert b"\x1b" not in done.stdout + done.stderr
