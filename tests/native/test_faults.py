"""Fault messages of a native FMU equal those of the core and of the Python flavour."""

import math

import numpy as np
import pytest

from fmi_export.model import Fault, Instance

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


@pytest.fixture(scope="module")
def library(unpacked, lag):
    from raw import Library

    return Library(unpacked(lag))


def core_of(model, constants=None, **values):
    core = Instance(model, np.zeros(1) if constants is None else constants)
    for name, value in values.items():
        core[name.replace("__", ".")] = value
    return core


@pytest.mark.parametrize("case", FAULTS)
def test_a_fault_in_a_step_is_that_of_the_core(library, lag, case):
    from raw import ERROR, OK

    values, h = FAULTS[case]
    core = core_of(lag, u=1.0)
    core.initialise()
    core.step(0.0, H)
    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        assert fmu.step(0) == OK
        for name, value in values.items():
            core[name] = value
        fmu.set(**values)
        with pytest.raises(Fault) as caught:
            core.step(3 * h, h)
        assert fmu.call("DoStep", *doubles(3 * H, h), 1) == ERROR
        assert fmu.log == [(ERROR, "logStatusError", f"at t = 0.00075 s: {printf(caught.value)}")]
        assert fmu.get("y", "level", "steps", "fault_code") == [
            core[name] for name in ("y", "level", "steps", "fault_code")
        ]
        with pytest.raises(Fault) as again:
            core.step(4 * H, H)
        assert fmu.step(4) == ERROR
        assert fmu.log[1][2].endswith(printf(again.value))


def doubles(*values):
    from ctypes import c_double

    return [c_double(value) for value in values]


def printf(sentence):
    """Return a message as a logger receives it: escaped, since it is a printf format."""
    return str(sentence).replace("%", "%%")


def test_the_python_flavour_says_the_same(library, build_fmu, lag, run_python):
    def host(path: str, cases: list) -> list:
        from drive import Fmu
        from fmpy.fmi1 import FMICallException

        answers = []
        for values, h in cases:
            fmu = Fmu(path, u=1.0)
            fmu.step(0)
            fmu.set(**values)
            try:
                fmu.fmi.doStep(0.00075, h)
            except FMICallException as error:
                answers.append([error.status, *fmu.get("fault_code", "y"), fmu.log[-1]])
            fmu.close()
        return answers

    for (values, h), theirs in zip(
        FAULTS.values(), run_python(host, path=build_fmu(lag), cases=list(FAULTS.values())), strict=True
    ):
        with library.instantiate(b"probe_lag") as fmu:
            fmu.begin(u=1.0)
            fmu.step(0)
            fmu.set(**values)
            status = fmu.call("DoStep", *doubles(0.00075, h), 1)
            said = fmu.log[-1][2].replace("%%", "%")
            assert [status, *fmu.get("fault_code", "y"), said] == theirs


def test_a_fault_in_initialization_mode_can_be_corrected(library, lag):
    from raw import ERROR, OK, WARNING

    def message(**values):
        with pytest.raises(Fault) as caught:
            core_of(lag, **values).initialise()
        return f"initialisation: {caught.value}"

    with library.instantiate() as fmu:
        fmu.set(u=11.0, offset=2)
        fmu.setup()
        fmu.call("EnterInitializationMode")
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
    from raw import OK, WARNING

    core = core_of(lag)
    core.initialise()
    core.inputs[0] = 4.0
    core.step(0.0, H)
    (warning,) = core.new_warnings()
    assert core.new_warnings() == []
    said = (WARNING, "logStatusWarning", f"at t = 0.0005 s: {printf(warning)}")
    with library.instantiate() as fmu:
        for _ in range(2):
            fmu.begin()
            statuses = []
            for n, u in enumerate((1.0, 4.0, 1.0, 3.5)):
                fmu.set(u=u)
                statuses += [fmu.step(n), *fmu.get("high")]
            assert statuses == [OK, 0, OK, 1, OK, 0, OK, 1]
            assert fmu.log == [said]
            fmu.log.clear()
            fmu.call("Reset")


def test_a_warning_that_is_true_from_the_start_is_logged_with_the_initialisation(library):
    from raw import WARNING

    with library.instantiate() as fmu:
        fmu.begin(u=4.0)
        assert [(status, text.split(" u =")[0]) for status, _, text in fmu.log] == [(WARNING, "initialisation: high:")]
        fmu.step(0)
        assert len(fmu.log) == 1


def test_a_step_that_fails_gives_no_warning(library):
    from raw import ERROR

    with library.instantiate() as fmu:
        fmu.begin()
        fmu.set(u=6.5)
        assert fmu.step(0) == ERROR
        assert [status for status, _, _ in fmu.log] == [ERROR]


@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [
        {"initial__orbit": 1.0, "gravity": 9.81},
        {"rb1__offset_x": 0.6e-3, "rb1__offset_y": -0.5e-3},
        {"eb2__offset_y": 1e-2},
        {"rb2__clearance": 0.0},
        {"Omega": 1e5},
    ],
)
def test_the_plant_explains_its_faults_as_the_core_does(unpacked, plant, plant_constants, values):
    from raw import ERROR, Library

    with pytest.raises(Fault) as caught:
        core_of(plant, plant_constants, **values).initialise()
    with Library(unpacked(plant, plant_constants)).instantiate() as fmu:
        fmu.set(**values)
        fmu.setup()
        fmu.call("EnterInitializationMode")
        assert fmu.call("ExitInitializationMode") == ERROR
        assert fmu.log[-1][2] == printf(f"initialisation: {caught.value}")
        assert fmu.get("fault_code") == [caught.value.code]
