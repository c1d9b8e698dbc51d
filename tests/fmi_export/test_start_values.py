"""A model exported with other start values: in the description, and in the slave that nobody gives any."""

import fmpy
import numpy as np
import pytest

from fmi_export.model import Instance, with_starts
from tests.support.messages import raises_naming

STARTS = {"gain": 2.5, "offset": -3.0, "u": 2.0, "hold": 1.0}


def started(path: str) -> list:
    from drive import Fmu

    fmu = Fmu(path)
    first = fmu.outputs()
    fmu.close()
    return first


def test_an_instance_has_the_start_values(lag):
    core = Instance(with_starts(lag, STARTS), np.zeros(1))
    assert {name: core[name] for name in STARTS} == STARTS
    assert core["time_constant"] == 1e-3


@pytest.mark.slow
def test_a_python_fmu_has_the_start_values(lag, build_fmu, run_python):
    changed = with_starts(lag, STARTS)
    path = build_fmu(changed)
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables if v.name in STARTS}
    assert {name: float({"true": 1, "false": 0}.get(text, text)) for name, text in starts.items()} == STARTS
    core = Instance(changed, np.zeros(1))
    core.initialise()
    assert run_python(started, path=str(path)) == core.outputs.tolist()
    assert core["y"] == -3.0
    assert core["level"] == 4.0


def test_unknown_names_and_values_out_of_range_are_refused(lag):
    with raises_naming(ValueError, "amplification, y"):
        with_starts(lag, {"amplification": 1.0, "y": 1.0})
    with raises_naming(ValueError, "u", "11 V"):
        with_starts(lag, {"u": 11.0})
