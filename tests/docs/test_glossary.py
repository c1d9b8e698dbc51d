"""The glossary defines terms as the code does."""

import math
from pathlib import Path

import pytest

from amb_cosim.scenario.scenario import cycle_period
from tests.support.messages import assert_names

GLOSSARY = Path(__file__).parents[2] / "docs" / "reference" / "glossary.md"


def test_glossary_says_what_a_cycle_is():
    entry = GLOSSARY.read_text(encoding="utf-8").partition("## Cycle\n")[2].partition("\n## ")[0]
    assert cycle_period(100.0 * math.pi) == pytest.approx(0.02)  # one revolution
    assert_names(entry, "one revolution", "first speed", f"{1e3 * cycle_period(0.0):g} ms")
