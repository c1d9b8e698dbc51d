"""The page on compatibility says of each tool what its tests came to, and a failure before anything else."""

import re
from pathlib import Path

from tools.compatibility.__main__ import COLUMNS

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "compatibility.md"


def marked():
    """Tool and FMUs of every mark in the tests."""
    for file in PAGE.parents[2].glob("tests/*/test_*.py"):
        if file != Path(__file__):
            text = file.read_text(encoding="utf-8")
            yield from re.findall(r'in_host\(\s*"([^"]+)", "([^"]+)"', text)
            yield from re.findall(r'mark\.host\(\s*"([^"]+)".*?fmus="([^"]+)"', text, re.DOTALL)


def test_the_page_in_the_reference_has_every_host_that_tests_run_and_no_failure():
    lines = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line]
    assert tuple(lines[0]) == COLUMNS
    rows = [dict(zip(COLUMNS, line, strict=True)) for line in lines[2:]]
    assert {(row["tool"], row["FMUs"]) for row in rows} == set(marked())
    assert {row["result"].partition(" (")[0] for row in rows} == {"yes"}
