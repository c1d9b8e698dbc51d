"""The slave of both flavours and both versions of FMI: states, instances side by side, initialisation and steps."""

import math
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p

import pytest
from raw import ERROR, OK, Callbacks

from tests.native.conftest import FLAVOURS
from tests.support.messages import assert_names

ANY, SETTABLE = range(5), range(3)
READABLE = ([1, 2, 3, 4], ANY)  # of FMI 2.0 and of FMI 3.0
# In which states a call is allowed, by their numbers, after the tables of calling sequences of the standards.
ALLOWED = {
    "SetDebugLogging": ANY,
    "EnterInitializationMode": [0],
    "ExitInitializationMode": [1],
    "DoStep": [2],
    "Terminate": [2],
    "Reset": ANY,
    **dict.fromkeys(("GetReal", "GetInteger", "GetBoolean"), READABLE),
    **dict.fromkeys(("SetReal", "SetInteger", "SetBoolean"), SETTABLE),
    **dict.fromkeys(("GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializedFMUstateSize"), ANY),
}
# A status may be requested in the error state too, which the standard leaves out: with logging off it is where a host
# finds the reason.
ALLOWED2 = {
    "SetupExperiment": [0],
    "GetString": [1, 2, 3, 4],
    "SetString": SETTABLE,
    **dict.fromkeys(("GetRealStatus", "GetBooleanStatus", "GetStringStatus"), range(2, 5)),
}
ALLOWED3 = {"GetInt64": ANY, "SetInt64": SETTABLE}
CALLS = [(flavour, name) for flavour in FLAVOURS for name in (*ALLOWED, *(ALLOWED3 if "3" in flavour else ALLOWED2))]


def bring_to(fmu, state):
    if state > 0:
        fmu.enter()
    if state > 1:
        fmu.call("ExitInitializationMode")
    if state == 3:
        fmu.call("Terminate")
    elif state == 4:
        assert fmu.restore(None) == ERROR


def call_rightly(fmu, function, saved):
    """Call a function with arguments that are right, of values none at all."""
    if function in ("EnterInitializationMode", "DoStep", "SetDebugLogging") and fmu.library.version == 3:
        return {"E": fmu.enter, "D": lambda: fmu.step(0), "S": lambda: fmu.debug(True)}[function[0]]()
    arguments = {
        "SetDebugLogging": (1, c_size_t(0), None),
        "SetupExperiment": (0, c_double(0.0), c_double(0.0), 0, c_double(0.0)),
        "DoStep": (c_double(0.0), c_double(250e-6), 1),
        "GetFMUstate": (byref(c_void_p()),),
        "FreeFMUstate": (byref(c_void_p()),),
        "SetFMUstate": (saved,),
        "SerializedFMUstateSize": (saved, byref(c_size_t())),
        "SerializeFMUstate": (saved, None, c_size_t(0)),
        "DeSerializeFMUstate": (None, c_size_t(0), byref(c_void_p())),
        "GetRealStatus": (2, byref(c_double())),
        "GetBooleanStatus": (3, byref(c_int())),
        "GetStringStatus": (1, byref(c_char_p())),
    }
    nothing = (None, c_size_t(0), None, c_size_t(0)) if function[:3] in ("Get", "Set") else ()
    return fmu.call(function, *arguments.get(function, nothing))


@pytest.mark.parametrize("state", ANY)
@pytest.mark.parametrize(("flavour", "function"), CALLS)
def test_a_call_is_allowed_only_in_the_states_of_the_standard(library_of, flavour, function, state):
    library = library_of(flavour)
    allowed = (ALLOWED | ALLOWED2 | ALLOWED3)[function]
    allowed = allowed[library.version - 2] if allowed is READABLE else allowed
    with library.instantiate() as fmu:
        bring_to(fmu, state)
        saved = fmu.save()
        del fmu.log[:]
        status = call_rightly(fmu, function, saved)
        if state in allowed:
            assert (status, fmu.log) == (OK, [])
        else:
            assert status == ERROR
            message = fmu.log[0][2]
            assert_names(message, f"{library.function(function)}", f"'{library.states[state]}'")
            assert all(f"'{library.states[name]}'" in message for name in allowed)
            readable = fmu.transfer("Get", next(iter(library.kinds)), [], [])
            assert (readable, fmu.get("fault_code")) == (OK, [998]), "outputs can be read in the error state"
        assert fmu.call("FreeFMUstate", byref(saved)) == OK


# Instances -----------------------------------------------------------------------------------------------------------


WRONG = [
    ({"guid": "{0}"}, ("modelDescription.xml", "guid {0}", "resources/model.bin")),
    ({"guid": None}, ("modelDescription.xml", "guid NULL")),
    ({"name": b""}, ("name",)),
    ({"name": None}, ("name",)),
]
WRONG2 = [({"kind": 0}, ("co-simulation", "model exchange"))]
WRONG3 = [({"events": True}, ("event mode",)), ({"intermediate": [0]}, ("within a step",))]


@pytest.mark.parametrize(
    ("flavour", "wrong", "facts"),
    [(f, *case) for f in FLAVOURS for case in (*WRONG, *(WRONG3 if "3" in f else WRONG2))],
)
def test_failed_instantiation_returns_null_and_logs_the_reason(library_of, flavour, wrong, facts):
    library = library_of(flavour)
    fmu = library.instantiate(**wrong, logging=0)
    assert fmu.pointer is None
    assert [(status, category) for status, category, _ in fmu.log] == [(ERROR, "logStatusError")]
    assert_names(fmu.log[0][2], *facts)
    assert library.instantiate(**wrong, callbacks=False).pointer is None


def test_an_instance_needs_a_logger(library2):
    assert library2.c.fmi2Instantiate(b"no logger", 1, b"{0}", None, byref(Callbacks()), 0, 1) is None
    assert library2.instantiate(callbacks=False).pointer is None


def test_calls_with_a_null_instance_are_harmless(library):
    nobody = library.instantiate(guid="{0}")
    for function in (*ALLOWED, *(ALLOWED2 if library.version == 2 else ()), "SerializeFMUstate", "DeSerializeFMUstate"):
        assert call_rightly(nobody, function, c_void_p()) == ERROR
    getattr(library.c, library.function("FreeInstance"))(None)


def test_version_and_platform_are_those_of_the_standard(library):
    answers = [getattr(library.c, library.function(question))() for question in library.questions]
    assert answers == ([b"2.0", b"default"] if library.version == 2 else [b"3.0"])


def test_two_interleaved_instances_run_as_each_alone(library):
    def alone(sign):
        with library.instantiate().begin(gain=2.0) as fmu:
            return [(fmu.set(u=sign * n), fmu.step(n), *fmu.get("y", "level", "steps")) for n in range(4)]

    with library.instantiate(b"one") as one, library.instantiate(b"two") as two:
        one.begin(gain=2.0)
        two.begin(gain=2.0)
        rows = [], []
        for n in range(4):
            for fmu, sign, run in ((one, 1, rows[0]), (two, -1, rows[1])):
                run.append((fmu.set(u=sign * n), fmu.step(n), *fmu.get("y", "level", "steps")))
        assert list(rows) == [alone(1), alone(-1)]
        one.set(u=5.0)
        assert (one.step(4), two.step(4)) == (ERROR, OK)
        assert (len(one.log), len(two.log)) == (1, 0), "each instance has its own logger"


def test_a_run_after_reset_has_the_start_values_and_repeats_itself(library):
    with library.instantiate() as fmu:
        runs = []
        for gain in (3.0, None, None):
            fmu.begin(**({} if gain is None else {"gain": gain}), u=2.0)
            assert [fmu.step(n) for n in range(5)] == [OK] * 5
            runs.append(fmu.get("y", "steps"))
            assert fmu.call("Reset") == OK
    assert runs[1] == runs[2] == [pytest.approx(2.0 * (1.0 - math.exp(-1.25))), 5]
    assert runs[0] == [pytest.approx(3.0 * runs[1][0]), 5]


# Initialisation and steps --------------------------------------------------------------------------------------------


def test_outputs_follow_inputs_at_once_in_initialization_mode_only(library):
    with library.instantiate() as fmu:
        fmu.set(u=1.0)
        fmu.enter()
        levels = fmu.get("level")
        fmu.set(u=2.0)
        levels += fmu.get("level")
        fmu.call("ExitInitializationMode")
        fmu.set(u=3.0)
        levels += fmu.get("level")
        assert fmu.step(0) == OK
        assert levels + fmu.get("level") == [2.0, 4.0, 4.0, 6.0]


def test_a_tunable_parameter_may_change_during_the_run(library):
    with library.instantiate().begin(u=1.0) as fmu:
        fmu.set(gain=4.0)
        fmu.step(0)
        assert fmu.get("y") == [pytest.approx(4 * (1 - math.exp(-0.25)), rel=1e-12)]


@pytest.mark.parametrize(("start", "stop"), [(math.nan, None), (math.inf, None), (1.0, 0.5), (0.0, math.nan)])
def test_an_impossible_experiment_is_refused(library, start, stop):
    with library.instantiate() as fmu:
        assert fmu.enter(start, stop) == ERROR
        assert "time = " in fmu.log[0][2]
        fmu.call("Reset")
        assert fmu.enter(1.0, 2.0) == OK


def test_a_step_beyond_the_stop_time_is_refused_and_the_run_can_end(library):
    with library.instantiate() as fmu:
        fmu.enter(0.0, 1e-3)
        fmu.call("ExitInitializationMode")
        assert [fmu.step(n) for n in range(4)] == [OK] * 4
        before = fmu.get("y", "steps")
        assert fmu.step(4) == ERROR
        message = "at t = 0.001 s: a step of 0.00025 s would end after the stop time of the experiment, 0.001 s"
        assert fmu.log == [(ERROR, "logStatusError", message)]
        if library.version == 2:
            assert fmu.reason() == message
        assert (fmu.get("y", "steps", "fault_code"), fmu.last_time()) == ([*before, 0], 1e-3)
        assert fmu.call("Terminate") == OK


@pytest.mark.parametrize(("steps", "h"), [(1000, 1e-3), (100_000, 1e-5), (3, 1.0 / 3.0)])
def test_a_host_that_sums_its_steps_reaches_the_stop_time(library, steps, h):
    """With a last step of the remaining time, which may be 1e-17 s or exceed the exact value by 1e-12 s."""
    stop = 100.0 + steps * h
    with library.instantiate() as fmu:
        fmu.enter(100.0, stop)
        fmu.call("ExitInitializationMode")
        time = 100.0
        for _ in range(steps):
            assert fmu.advance(time, h) == OK, fmu.log
            time += h
        assert time != stop or steps == 3, "the sum must differ from the product to show anything"
        if time < stop:
            assert fmu.advance(time, stop - time) == OK, fmu.log
        assert fmu.call("Terminate") == OK


@pytest.mark.parametrize("h", [1e-9, 1e-17, 5e-324])
def test_a_tiny_step_makes_a_tiny_change(library, h):
    with library.instantiate().begin(u=1.0) as fmu:
        fmu.step(0)
        (y,) = fmu.get("y")
        assert fmu.advance(250e-6, h) == OK
        assert fmu.get("y") == [pytest.approx(y, abs=2.0 * h / 1e-3 + 1e-16)]


def test_an_earlier_state_or_a_reset_leaves_the_error_state(library):
    with library.instantiate().begin(u=1.0) as fmu:
        fmu.step(0)
        saved, before = fmu.save(), fmu.get("y", "steps")
        fmu.set(u=5.0)
        assert (fmu.step(1), fmu.step(1), fmu.call("Terminate")) == (ERROR, ERROR, ERROR)
        assert (fmu.get("y", "steps", "fault_code"), fmu.last_time()) == ([*before, 1], 250e-6), "the last good ones"
        assert fmu.restore(saved) == OK
        if library.version == 2:
            assert fmu.reason() == ""
        assert (fmu.step(1), fmu.get("steps", "fault_code")) == (OK, [2, 0])
        fmu.set(u=5.0)
        assert (fmu.step(2), fmu.call("Reset")) == (ERROR, OK)
        fmu.begin()
        assert (fmu.step(0), fmu.get("steps", "fault_code")) == (OK, [1, 0])


def test_a_fault_is_not_reported_as_termination_by_the_model(library2):
    """Hosts take fmi2Terminated for success: FMPy, fmusim, PyFMI and others stop without a word."""
    with library2.instantiate().begin() as fmu:
        ended = c_int(-1)
        for u, status in ((1.0, OK), (5.0, ERROR)):
            fmu.set(u=u)
            assert fmu.step(0) == status
            assert (fmu.call("GetBooleanStatus", 3, byref(ended)), ended.value) == (OK, 0)
