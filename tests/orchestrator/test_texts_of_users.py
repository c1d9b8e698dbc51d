"""Files with byte order marks, and names with brackets and colons: read and printed unchanged."""

import codecs
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from rich.table import Table

import amb_cosim
from amb_assessment.assessment.format.criteria import load_criteria, packaged_criteria
from amb_cosim.controllers.block_file import read_blocks
from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.text_tables import html_of, print_parts, rendered, text_table
from amb_sweeps.axes import read_variations
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.rotor_file import load_rotor

BLOWER = Path(__file__).parents[1] / "amb_assessment" / "assessment" / "blower"
READ = {
    "rotor": (load_rotor, rotor_path("bath_rig").read_text(encoding="utf-8")),
    "scenario": (amb_cosim.Scenario.load, "base = 'fig4_9'\nend_cycle = 3\n"),
    "system": (load_system, "base = 'levitated'\n"),
    "controller": (read_blocks, (BLOWER / "controller.toml").read_text(encoding="utf-8")),
    "criteria": (lambda path: load_criteria([path]), packaged_criteria()["physics"].read_text(encoding="utf-8")),
    "alternatives": (lambda path: read_variations({"control": f"@{path}"}), "[PID]\n'c.on' = false\n"),
}


@pytest.mark.parametrize("kind", READ)
def test_a_byte_order_mark_is_ignored(kind, tmp_path):
    """Editors of Windows put the mark before the text."""
    read, text = READ[kind]
    file, results = tmp_path / "own.toml", []
    for mark in (b"", codecs.BOM_UTF8):
        file.write_bytes(mark + text.encode())
        results.append(repr(read(file)))
    assert results[0] == results[1]


def test_brackets_and_colons_in_a_name_are_no_markup(capsys):
    name = "pump [rev B] [/2] :warning: [bold]"
    table = Table(title=name)
    table.add_column(name)
    table.add_row(name)
    console = plain_console(width=80)
    console.print(table)
    console.print(name)
    assert capsys.readouterr().out.count(name) == 4
    assert name in rendered([name])


def test_package_runs_as_a_module():
    command = [sys.executable, "-m", "amb_cosim", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("amb-cosim")


@pytest.mark.parametrize(("width", "lines"), [(60, 1), (30, 2)])
def test_a_title_longer_than_its_table_wraps_at_the_screen(width, lines):
    """It was broken at the width of the table, word by word."""
    title = "Whirl of the free rotor at 41998 rpm"
    table, screen = text_table(title, ("mode", "(Hz)"), [("1", "10")]), StringIO()
    print_parts([table], Console(file=screen, force_terminal=True, color_system=None, width=width))
    shown = screen.getvalue().splitlines()
    assert " ".join(line.strip() for line in shown[:lines]) == title
    assert shown[lines].split() == ["mode", "(Hz)"]
    assert rendered([table]).splitlines()[0] == title
    assert title in html_of([table])


def test_a_file_has_sentences_in_one_line_and_tables_whole():
    """Its reader or another program wraps it; a terminal wraps at its width, between words."""
    sentence = "receptance at rest between bearings and sites within 0.1 % up to 2007 Hz " * 5
    table = text_table("Speeds", [f"speed {k} (rad/s)" for k in range(30)], [["100"] * 30])
    assert sentence.rstrip() in [line.rstrip() for line in rendered([table, sentence]).splitlines()]
    assert all(f"speed {k} (rad/s)" in rendered([table]).splitlines()[1] for k in range(30))
    screen = StringIO()
    print_parts([sentence], Console(file=screen, force_terminal=True, width=60, highlight=False))
    lines = screen.getvalue().splitlines()
    assert max(map(len, lines)) <= 60
    assert " ".join(" ".join(lines).split()) == sentence.strip()
