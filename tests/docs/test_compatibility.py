"""The pages on other tools name the hosts of the tests, their results without a failure, and tests that exist."""

import re
from pathlib import Path

from tools.compatibility.__main__ import COLUMNS

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "reference"
PAGE = PAGES / "compatibility.md"


def marked():
    """Tool and FMUs of every mark in the tests."""
    for file in ROOT.glob("tests/*/test_*.py"):
        if file != Path(__file__):
            text = file.read_text(encoding="utf-8")
            yield from re.findall(r'(?:in_host|host_marks)\(\s*"([^"]+)", "([^"]+)"', text)
            yield from re.findall(r'mark\.host\(\s*"([^"]+)".*?fmus="([^"]+)"', text, re.DOTALL)


def test_compatibility_page_lists_every_tested_host_without_failure():
    lines = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line]
    assert tuple(lines[0]) == COLUMNS
    rows = [dict(zip(COLUMNS, line, strict=True)) for line in lines[2:]]
    assert {(row["tool"], row["FMUs"]) for row in rows} == set(marked())
    assert {row["result"].partition(" (")[0] for row in rows} == {"yes"}


def test_each_line_of_the_page_on_other_tools_names_a_test():
    text = (PAGES / "other_tools.md").read_text(encoding="utf-8")
    files = list((ROOT / "tests").rglob("test_*.py"))
    known = {file.stem for file in files}
    for file in files:
        known.update(re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.MULTILINE))
    rows = [row for row in re.findall(r"^\|.*\|$", text, re.MULTILINE) if not re.fullmatch(r".* test \||[| -]+", row)]
    assert len(rows) > 30
    for row in rows:
        named = re.findall(r"\btest_\w+", row.rsplit("|", 2)[1])
        assert named, row
        assert set(named) <= known, row
