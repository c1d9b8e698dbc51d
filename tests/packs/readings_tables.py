"""`python -m tests.packs.readings_tables FILE` writes the tables of docs/validation/readings.md anew.

FILE is the readings.json that `amb-cosim study readings -o FOLDER` leaves in FOLDER; chapters that it lacks stay. A
test compares the names of readings and the numbers of statements with those that the pack has.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bath_thesis.studies.thesis_readings import MOVED

PAGE = Path(__file__).parents[2] / "docs" / "validation" / "readings.md"
TABLE = re.compile(r"^\| chapter (\d), (\d+) statements \|.*\n\| ---.*\n((?:\|.*\n)+)", re.MULTILINE)
FIRST = "the scenarios"  # as the first reading is called on the page


def table(chapter: str, found: Mapping[str, Any]) -> str:
    """Return the table of a chapter in Markdown: its readings by their misfit, the scenarios first among equals."""
    misfit, met, rows = found["misfit"][chapter], found["met"][chapter], found["rows"][chapter]
    first = next(iter(misfit))
    lines = [f"| chapter {chapter}, {len(rows)} statements | misfit | met | better | worse |", "| --- " * 5 + "|"]
    for name in sorted(misfit, key=lambda one: round(misfit[one], 3)):
        moves = [row["findings"][name]["misfit"] - row["findings"][first]["misfit"] for row in rows]
        better, worse = (str(sum(sign * move > MOVED for move in moves)) for sign in (-1.0, 1.0))
        message = f"**{FIRST}** | {misfit[name]:.3f} | {met[name]} | | |" if name == first else ""
        lines.append(f"| {message or f'{name} | {misfit[name]:.3f} | {met[name]} | {better} | {worse} |'}")
    return "\n".join(lines) + "\n"


def read_page() -> dict[int, tuple[int, set[str]]]:
    """Return number of statements and names of readings of each chapter on the page."""
    result = TABLE.findall(PAGE.read_text(encoding="utf-8"))
    return {
        int(chapter): (int(number), set(re.findall(r"^\| (.*?) \|", rows, re.M))) for chapter, number, rows in result
    }


def main(file: str) -> None:
    """Write the page."""
    result = json.loads(Path(file).read_text(encoding="utf-8"))
    old = PAGE.read_text(encoding="utf-8")
    text = TABLE.sub(lambda part: table(part[1], result) if part[1] in result["rows"] else part[0], old)
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
