"""Any input gives finite outputs or a fault with one message."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from rig import ACTUATOR, ACTUATOR_CONSTANTS

from fmi_export.model import FAULT_NOT_FINITE, FAULT_RANGE, Fault, Instance

INTERFACE = ACTUATOR.interface

PARAMETERS, INPUTS = INTERFACE.of("parameter"), INTERFACE.of("input")
NAMES = [v.name for v in INTERFACE.variables]


def allowed(v):
    """A value within the declared range; the most extreme ones are tried first."""
    if v.type == "Boolean":
        return st.sampled_from([0.0, 1.0])
    if v.type == "Integer":
        return st.integers(int(v.minimum), int(v.maximum)).map(float)
    return st.floats(v.minimum, v.maximum)


def anything(_):
    return st.floats(allow_nan=True, allow_infinity=True)


def some(variables, values):
    return st.lists(st.sampled_from(variables), max_size=6, unique=True).flatmap(
        lambda chosen: st.fixed_dictionaries({v.name: values(v) for v in chosen})
    )


near = st.fixed_dictionaries({f"{b}.{a}": st.floats(-1.2e-3, 1.2e-3) for b in ("mb1", "mb2") for a in "xy"})
lengths = st.floats(1e-9, 10.0)


def drive(parameters, inputs, lengths):
    """Return the code of the fault that ended a case, or None; check all outputs and the message of the fault."""
    made = Instance(ACTUATOR, ACTUATOR_CONSTANTS)

    def put(values):
        for name, value in values.items():
            made[name] = value

    fault = None
    try:
        put(parameters)
        made.initialise()
        time = 0.0
        for now, h in zip(inputs, lengths, strict=True):
            check(made)
            put(now)
            made.step(time, h)
            time += h
    except Fault as caught:
        fault = caught
    check(made)
    if fault is None:
        return None
    assert made["fault_code"] == fault.code
    assert any(name in str(fault) for name in NAMES), str(fault)
    return fault.code


def check(made):
    assert np.all(np.isfinite(made.outputs))
    for v in INTERFACE.of("output"):
        if v.type == "Boolean":
            assert made[v.name] in (0.0, 1.0)


steps = st.lists(st.tuples(some(INPUTS, allowed), near, lengths), min_size=1, max_size=4)


@settings(max_examples=150)
@given(some(PARAMETERS, allowed), steps)
def test_values_within_the_declared_ranges_work_or_are_refused(parameters, taken):
    code = drive(parameters, [inputs | place for inputs, place, _ in taken], [h for *_, h in taken])
    assert code is None or code in ACTUATOR.faults


@settings(max_examples=80)
@given(some(PARAMETERS, anything), some(INPUTS, anything), lengths)
def test_values_outside_the_declared_ranges_are_faults(parameters, inputs, h):
    code = drive(parameters, [inputs], [h])
    outside = [
        name
        for name, value in (parameters | inputs).items()
        if not INTERFACE[name].minimum <= value <= INTERFACE[name].maximum
    ]
    if outside:
        assert code is not None
    assert code is None or code in ACTUATOR.faults or FAULT_RANGE <= code < FAULT_NOT_FINITE


@given(st.sampled_from(["mb1.x", "mb1.y", "mb2.x", "mb2.y"]), st.integers(0, 2), st.sampled_from([-1.0, 1.0]))
def test_rotor_a_hair_from_the_magnet_still_has_a_finite_force(name, law, side):
    at = side * math.nextafter(1.2e-3, 0.0)
    assert drive({"force_law": law, name: at}, [{}], [1e-3]) is None
    assert drive({"force_law": law, name: side * 1.2e-3}, [{}], [1e-3]) in ACTUATOR.faults
