"""Faults and warnings of FMUs of both flavours, and of FMI 3.0, are those of the core."""

import math

import numpy as np
import pytest
from raw import ERROR, OK, WARNING

from fmi_export.model import Fault, Instance
from fmi_export.variables import filled

H = 250e-6

# What to set after initialisation, and the step size.
FAULTS = {
    "kernel": ({"u": 5.0}, H),
    "input above": ({"u": 11.0}, H),
    "input no number": ({"u": math.nan}, H),
    "input infinite": ({"u": -math.inf}, H),
    "parameter infinite": ({"gain": math.inf}, H),
    "output no number": ({"u": -7.0}, H),
    "output above": ({"u": 6.5}, H),
    "step zero": ({}, 0.0),
    "step backwards": ({}, -1e-3),
    "step no number": ({}, math.nan),
    "step infinite": ({}, math.inf),
}


def core_of(model, constants=None, **values):
    core = Instance(model, np.zeros(1) if constants is None else constants)
    for name, value in values.items():
        core[name.replace("__", ".")] = value
    return core


@pytest.mark.parametrize("case", FAULTS)
def test_a_fault_in_a_step_equals_that_of_the_core(library, lag, case):
    values, h = FAULTS[case]
    core = core_of(lag, u=1.0)
    core.initialise()
    core.step(0.0, H)
    with library.instantiate().begin(u=1.0) as fmu:
        assert fmu.step(0) == OK
        for name, value in values.items():
            core[name] = value
        fmu.set(**values)
        with pytest.raises(Fault) as caught:
            core.step(3 * h, h)
        assert fmu.advance(3 * H, h) == ERROR
        assert fmu.log == [(ERROR, "logStatusError", library.escaped(f"at t = 0.00075 s: {caught.value}"))]
        assert library.version == 3 or fmu.reason() == str(caught.value)
        assert fmu.get("y", "level", "steps", "fault_code") == [
            core[name] for name in ("y", "level", "steps", "fault_code")
        ]
        with pytest.raises(Fault) as again:
            core.step(4 * H, H)
        assert fmu.step(4) == ERROR
        assert fmu.log[1][2].endswith(library.escaped(str(again.value)))


def test_a_fault_in_initialization_mode_can_be_corrected(library, lag):
    def message(**values):
        with pytest.raises(Fault) as caught:
            core_of(lag, **values).initialise()
        return f"initialisation: {caught.value}"

    with library.instantiate() as fmu:
        fmu.set(u=11.0, offset=2)
        fmu.enter()
        assert fmu.get("fault_code") == [1000 + library.variables["u"][0]]
        fmu.set(u=1.0)
        assert fmu.get("fault_code", "level") == [0, 2.0]
        fmu.set(offset=6)
        assert fmu.call("ExitInitializationMode") == ERROR
        assert fmu.log == [
            (WARNING, "logStatusWarning", message(u=11.0, offset=2)),
            (ERROR, "logStatusError", message(u=1.0, offset=6)),
        ]
        assert fmu.get("fault_code") == [1000 + library.variables["offset"][0]]
        assert fmu.call("Reset") == OK
        fmu.begin()


def test_a_warning_is_logged_once_until_the_instance_is_reset(library, lag):
    core = core_of(lag)
    core.initialise()
    core.inputs[0] = 4.0
    core.step(0.0, H)
    ((at, sentence),) = core.model.interface.warnings.items()
    warning = f"{core.model.interface.variables[at].name}: {filled(sentence, core.__getitem__)}"
    logged = (WARNING, "logStatusWarning", library.escaped(f"at t = 0.0005 s: {warning}"))
    with library.instantiate() as fmu:
        for _ in range(2):
            fmu.begin()
            statuses = []
            for n, u in enumerate((1.0, 4.0, 1.0, 3.5)):
                fmu.set(u=u)
                statuses += [fmu.step(n), *fmu.get("high")]
            assert statuses == [OK, 0, OK, 1, OK, 0, OK, 1]
            assert fmu.log == [logged]
            fmu.log.clear()
            fmu.call("Reset")


def test_a_warning_true_from_the_start_is_logged_at_initialisation(library):
    with library.instantiate().begin(u=4.0) as fmu:
        assert [(status, text.split(" u =")[0]) for status, _, text in fmu.log] == [(WARNING, "initialisation: high:")]
        fmu.step(0)
        assert len(fmu.log) == 1


def test_a_step_that_fails_gives_no_warning(library):
    with library.instantiate().begin() as fmu:
        fmu.set(u=6.5)
        assert fmu.step(0) == ERROR
        assert [status for status, _, _ in fmu.log] == [ERROR]
