"""A model with other start values, which its description and its instances have."""

import numpy as np

from fmi_export.model import Instance, with_starts
from tests.support.messages import raises_naming

STARTS = {"gain": 2.5, "offset": -3.0, "u": 2.0, "hold": 1.0}


def test_an_instance_has_the_start_values(lag):
    core = Instance(with_starts(lag, STARTS), np.zeros(1))
    assert {name: core[name] for name in STARTS} == STARTS
    assert core["time_constant"] == 1e-3


def test_unknown_names_and_values_out_of_range_are_refused(lag):
    with raises_naming(ValueError, "amplification, y"):
        with_starts(lag, {"amplification": 1.0, "y": 1.0})
    with raises_naming(ValueError, "u", "11 V"):
        with_starts(lag, {"u": 11.0})
