"""The page that compares runs of other tools' FMUs with FMPy."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from informed import informed_fmu

from tools.compatibility.foreign_fmus import Comparison, compare, difference, distinct, experiment, page


def columns(*values, start=0.0):
    return {"time": start + np.arange(len(values))[:, None], "y": np.array(values, float)[:, None]}


def test_the_difference_is_the_largest_and_counts_the_start():
    assert difference(columns(0.0, 1.0, 2.0), columns(5.0, 1.0, 2.5))["difference"] == 5.0
    assert difference(columns(5.0, 1.0, 2.0), columns(5.0, 1.0, 2.5))["difference"] == 0.5


def test_other_times_are_a_difference():
    assert difference(columns(1.0, 2.0, start=0.5), columns(1.0, 2.0))["difference"] == 0.5
    shorter = difference(columns(1.0), columns(1.0, 2.0))
    assert (shorter["times"], shorter["difference"]) == (1, 0.0)
    assert "1 more" in shorter["note"]


def test_a_value_that_only_one_has_is_infinitely_off():
    assert difference(columns(np.nan, 1.0), columns(np.nan, 1.0))["difference"] == 0.0
    assert difference(columns(np.nan, 1.0), columns(0.0, 1.0))["difference"] == np.inf


class Default:
    startTime, stopTime, stepSize = "1.0", "5.0", "0.002"


def test_steps_are_those_of_the_default_experiment_up_to_a_thousand():
    assert experiment(Default) == {"start": 1.0, "stop": 3.0, "step": 0.002}
    assert experiment(None) == {"start": 0.0, "stop": 1.0, "step": 0.01}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")
def test_fmus_agree_with_fmpy_and_those_that_cannot_run_are_named(fmu_from_c, tmp_path):
    for version in (2, 3):
        informed_fmu(fmu_from_c, tmp_path, version, 'stopTime="0.5" stepSize="0.125" tolerance="1e-3"')
    (tmp_path / "copy.fmu").write_bytes((tmp_path / "Informed2.fmu").read_bytes())
    (tmp_path / "damaged.fmu").write_bytes(b"PK")
    rows = compare(distinct([tmp_path]))
    assert sorted((row.fmi, row.times, row.difference) for row in rows) == [("2.0", 5, 0.0), ("3.0", 5, 0.0)]
    failed = Comparison("broken", "a tool", "2.0", note="why")
    assert "| broken | a tool | 2.0 | 0 | 0 | why |" in page([*rows, failed])
