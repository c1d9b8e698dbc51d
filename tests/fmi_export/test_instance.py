"""One instance in plain Python: checks, faults, repeatability."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fmi_export.interface import interface
from fmi_export.model import FAULT_NOT_FINITE, FAULT_RANGE, FAULT_STEP_SIZE, Fault, Instance, Model
from fmi_export.variables import input_, output
from tests.support.messages import raises_naming

H = 250e-6


@pytest.fixture
def instance(lag):
    made = Instance(lag, np.zeros(1))
    made.initialise()
    return made


def test_kernels_receive_the_constants(lag):
    made = Instance(lag, np.array([0.25]))
    made.initialise()
    assert made["y"] == 0.25


def test_the_step_response_is_the_exponential(instance):
    instance["u"] = 2.0
    for n in range(40):
        instance.step(n * H, H)
    assert instance["y"] == pytest.approx(2.0 * (1.0 - math.exp(-40 * H / 1e-3)), rel=1e-12)
    assert instance["steps"] == 40


@pytest.mark.parametrize(
    ("values", "h", "facts", "code", "of"),
    [
        ({"u": 11.0}, H, ("u = 11 V", ">= -10", "<= 10 V"), FAULT_RANGE, "u"),
        ({"u": math.nan}, H, ("u = nan V", ">= -10", "<= 10 V"), FAULT_RANGE, "u"),
        ({"time_constant": -1.0}, H, ("time_constant = -1 s", ">= 1e-06 s"), FAULT_RANGE, "time_constant"),
        ({"gain": math.inf}, H, ("gain = inf", "finite"), FAULT_RANGE, "gain"),
        ({"u": 6.5}, H, ("level", "13 V", "<= 12 V"), FAULT_NOT_FINITE, "level"),  # an output
        ({"u": 5.0}, H, ("u = 5 V is 100 % too much (%s %n)",), 1, None),  # of the kernel, with the present values
        *(({}, h, ("step size", f"{h:g} s", "> 0 s"), FAULT_STEP_SIZE, None) for h in (0.0, -1e-3, math.nan, math.inf)),
    ],
)
def test_a_fault_names_variable_value_unit_and_range(instance, values, h, facts, code, of):
    for name, value in values.items():
        instance[name] = value
    with raises_naming(Fault, *facts) as caught:
        instance.step(0.0, h)
    assert caught.value.code == instance.fault == instance["fault_code"]
    assert caught.value.code == code + (instance.model.interface.position[of] if of else 0)


def test_bad_values_are_refused_at_initialisation_too(lag):
    made = Instance(lag, np.zeros(1))
    made["offset"] = 6
    with raises_naming(Fault, "offset", "6", ">= -5", "<= 5"):
        made.initialise()


def test_an_output_that_the_kernel_does_not_write_is_an_error(lag, instance):
    """Not even at a second initialisation does it keep the value of the run before."""
    instance.step(0.0, H)
    forgetful = Instance(replace(lag, initialise=lambda *_: 0), np.zeros(1))
    forgetful.outputs[:] = instance.outputs
    for _ in range(2):
        with raises_naming(Fault, lag.interface.of("output")[0].name, "finite"):
            forgetful.initialise()


def test_a_nan_from_a_kernel_does_not_reach_the_outputs(instance):
    instance["u"] = 1.0
    instance.step(0.0, H)
    good = instance.outputs.copy()
    instance["u"] = -7.0
    with raises_naming(Fault, "y", "finite") as caught:
        instance.step(H, H)
    assert caught.value.code == FAULT_NOT_FINITE + instance.model.interface.position["y"]
    np.testing.assert_array_equal(instance.outputs[:-1], good[:-1])


def test_fault_and_message_persist_until_the_next_initialisation(instance):
    instance["u"] = 11.0
    with pytest.raises(Fault):
        instance.step(0.0, H)
    instance["u"] = 1.0
    for n in (1, 2):
        with raises_naming(Fault, "earlier fault", "u", "11 V"):
            instance.step(n * H, H)
    instance.initialise()
    instance.step(0.0, H)
    assert instance["fault_code"] == 0
    assert instance["steps"] == 1


def test_message_of_a_fault_has_the_value_that_the_kernel_computed():
    table = interface(
        input_("u", "V", "Input"), output("y", "V", "Output"), output("fault_code", "1", "", type="Integer")
    )

    def initialise(constants, parameters, inputs, state, work, outputs):
        outputs[0] = inputs[0]
        return 1 if inputs[0] > 2.0 else 0

    def step(constants, parameters, inputs, state, work, outputs, time, step_size):
        return initialise(constants, parameters, inputs, state, work, outputs)

    model = Model(
        "one", "", table, initialise, step, 0, 0, (), {1: "y = {y} V is too much for a step of {step_size} s"}
    )
    made = Instance(model, np.zeros(1))
    made.initialise()
    made["u"] = 3.0
    with pytest.raises(Fault, match=r"y = 3 V is too much for a step of 0\.00025 s"):
        made.step(0.0, H)
    assert made["y"] == 0.0
