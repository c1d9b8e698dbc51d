"""Forces on the page of scenarios are those of the table that a command writes, and speeds those of the scenarios."""

import re
from pathlib import Path

import numpy as np
import pytest

from amb_cosim.scenario.scenario import load_scenario
from tools.contact_forces import read_page

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "validation" / "scenarios.md"
ROWS = re.compile(r"^\|(?P<names>[^|]*)\|(?P<what>[^|]*)\|.*\|(?P<here>[^|]*)\|$", re.MULTILINE)
SPEEDS = re.compile(r"((?:[\d.]+(?:, | to | and ))*[\d.]+) rpm")
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


def speeds_on_the_page():
    """Yield names of scenarios and the speeds (rpm) in their descriptions."""
    for row in ROWS.finditer(PAGE.read_text(encoding="utf-8")):
        if told := SPEEDS.search(row["what"]):
            yield re.findall(r"`(\w+)`", row["names"]), [float(number) for number in re.findall(r"[\d.]+", told[1])]


def test_speeds_of_machines_on_the_page_are_those_of_its_scenarios_in_rpm():
    assert not re.search(r"rad/s|\bHz|1/min", PAGE.read_text(encoding="utf-8"))
    rows = list(speeds_on_the_page())
    assert len(rows) > 12
    for names, told in rows:
        run = {60.0 * load_scenario(name).initial_speed / (2.0 * np.pi) for name in names}
        assert sorted(run) == pytest.approx(sorted(told)[: len(run)], rel=5e-4), names
