"""The page on other tools' FMUs and archives names tests that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_each_line_of_the_page_names_a_test():
    text = (ROOT / "docs" / "reference" / "other_tools.md").read_text(encoding="utf-8")
    defined = set()
    for file in (ROOT / "tests").rglob("test_*.py"):
        defined.update(re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.MULTILINE))
    named = set(re.findall(r"`(test_\w+)`", text))
    assert not named - defined
    for row in re.findall(r"^\|.*\|$", text, re.MULTILINE):
        assert row.startswith("| ---") or row.endswith("| test |") or named & set(re.findall(r"test_\w+", row)), row
