"""Contact forces that the page of scenarios quotes are those of the table that a command writes."""

import re
from pathlib import Path

import pytest

from tools.contact_forces import read_page

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "validation" / "scenarios.md"
ROWS = re.compile(r"^\|(?P<names>[^|]*)\|.*\|(?P<here>[^|]*)\|$", re.MULTILINE)
NAMES = re.compile(r"`(\w+)`|Fig\. (\d)\.(\d+)")
FORCES = re.compile(r"((?:[\d.]+(?:, | and | to ))*[\d.]+) (kN|MN)\b")
OF_ANOTHER = {"drop_mount": ("drop",)}  # what it is compared with in its row


def quoted(page):
    """Yield scenarios, force and its unit (kN) for each force in the last column of the tables of a page."""
    for row in ROWS.finditer(page.read_text(encoding="utf-8")):
        names = [name or f"fig{chapter}_{figure}" for name, chapter, figure in NAMES.findall(row["names"])]
        for forces, unit in FORCES.findall(row["here"]):
            yield from ((names, force, 1e3 if unit == "MN" else 1.0) for force in re.findall(r"[\d.]+", forces))


FORCES_OF = read_page()
QUOTED = [entry for entry in quoted(PAGE) if set(entry[0]) & set(FORCES_OF)]


@pytest.mark.parametrize(("names", "force", "unit"), QUOTED, ids=str)
def test_force_is_the_rounded_peak_of_its_run(names, force, unit):
    scenarios = [*names, *(other for name in names for other in OF_ANOTHER.get(name, ()))]
    peaks = [1e-3 * peak / unit for name in scenarios for peak, *_ in FORCES_OF.get(name, {}).values()]
    rounding = 0.5 * 10.0 ** -len(force.partition(".")[2])
    assert min(abs(peak - float(force)) for peak in peaks) <= 1.001 * rounding
