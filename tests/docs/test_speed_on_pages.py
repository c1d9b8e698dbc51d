"""The computing time that README states is that of its run at the speed of the page of benchmarks."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def found(pattern, text):
    (groups,) = re.findall(pattern, text)
    return groups


def test_computing_time_of_the_first_run_is_its_length_over_its_speed():
    """The printed summary has the length (time in contact OF it); the benchmarks have the factor to real time."""
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    benchmarks = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    length = float(found(r"time in contact +[\d.]+ s of ([\d.]+) s", readme))
    factor = float(found(r"`fig4_9` runs at (\d+) times real time", benchmarks))
    stated, milliseconds, times = found(r"The ([\d.]+) s of the run above take (\d+) ms, which is (\d+) times", readme)
    assert float(stated) == pytest.approx(length, abs=0.005)
    assert float(times) == factor
    assert float(milliseconds) == pytest.approx(1e3 * length / factor, abs=0.5)
