"""The page on other tools' FMUs and archives names tests that exist, in each line of its tables."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_each_line_of_the_page_names_a_test():
    text = (ROOT / "docs" / "reference" / "other_tools.md").read_text(encoding="utf-8")
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
