"""The state machine of the standard, wrong arguments, logging, instances side by side."""

import math
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest

STATES = ("instantiated", "initialization mode", "step complete", "terminated", "error")
READABLE = STATES[1:]
SETTABLE = STATES[:3]

# In which states a call is allowed, after the tables of calling sequences of the standard. A status may be asked for in
# the error state too, which the standard leaves out: with logging off it is where a host finds the reason.
ALLOWED = {
    "SetDebugLogging": STATES,
    "SetupExperiment": STATES[:1],
    "EnterInitializationMode": STATES[:1],
    "ExitInitializationMode": STATES[1:2],
    "Terminate": STATES[2:3],
    "Reset": STATES,
    "GetReal": READABLE,
    "GetInteger": READABLE,
    "GetBoolean": READABLE,
    "GetString": READABLE,
    "SetReal": SETTABLE,
    "SetInteger": SETTABLE,
    "SetBoolean": SETTABLE,
    "SetString": SETTABLE,
    "GetFMUstate": STATES,
    "SerializedFMUstateSize": STATES,
    "FreeFMUstate": STATES,
    "SetFMUstate": STATES,
    "GetRealStatus": STATES[2:],
    "GetBooleanStatus": STATES[2:],
    "GetStringStatus": STATES[2:],
    "DoStep": STATES[2:3],
}


@pytest.fixture(scope="module")
def library(unpacked, lag):
    from raw import Library

    return Library(unpacked(lag))


def bring_to(fmu, state):
    if state == "instantiated":
        return
    fmu.setup()
    fmu.call("EnterInitializationMode")
    if state == "initialization mode":
        return
    fmu.call("ExitInitializationMode")
    if state == "terminated":
        fmu.call("Terminate")
    elif state == "error":
        assert fmu.call("SetString", byref(c_uint(0)), c_size_t(1), byref(c_char_p(b""))) == 3


def arguments_of(function, saved):
    nothing = (None, c_size_t(0), None)
    return {
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
    }.get(function, nothing if function[:3] in ("Get", "Set") else ())


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("function", ALLOWED)
def test_a_call_is_allowed_in_the_states_of_the_standard_only(library, function, state):
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        bring_to(fmu, state)
        saved = fmu.save()
        del fmu.log[:]
        status = fmu.call(function, *arguments_of(function, saved))
        if state not in ALLOWED[function]:
            assert status == ERROR
            assert f"fmi2{function} is not allowed in state '{state}'" in fmu.log[0][2]
            for name in ALLOWED[function]:
                assert f"'{name}'" in fmu.log[0][2]
            assert fmu.call("GetReal", None, c_size_t(0), None) == OK, "outputs can be read in the error state"
            assert fmu.get("fault_code") == [998]
        else:
            assert status == OK
        assert fmu.call("FreeFMUstate", byref(saved)) == OK


def test_an_instance_in_the_error_state_can_be_reset(library):
    from raw import OK

    with library.instantiate() as fmu:
        bring_to(fmu, "error")
        assert fmu.call("Reset") == OK
        fmu.begin(u=2.0)
        assert fmu.step(0) == OK
        assert fmu.get("y", "fault_code") == [pytest.approx(2.0 * (1.0 - math.exp(-0.25))), 0]


def test_a_run_after_reset_has_the_start_values_and_repeats_itself(library):
    from raw import OK

    with library.instantiate() as fmu:
        runs = []
        for gain in (3.0, None, None):
            fmu.begin(**({} if gain is None else {"gain": gain}), u=2.0)
            assert [fmu.step(n) for n in range(5)] == [OK] * 5
            runs.append(fmu.get("y", "steps"))
            fmu.call("Reset")
    assert runs[1] == runs[2]
    assert runs[0] == [pytest.approx(3.0 * runs[1][0]), 5]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"guid": "{0}"}, "the modelDescription.xml has guid {0}, but resources/model.bin belongs to {"),
        ({"guid": None}, "the modelDescription.xml has guid NULL"),
        ({"kind": 0}, "this is an FMU for co-simulation, not for model exchange"),
        ({"name": b""}, "an instance needs a name"),
        ({"name": None}, "an instance needs a name"),
    ],
)
def test_an_instance_that_cannot_be_made_is_none_and_the_log_says_why(library, wrong, sentence):
    fmu = library.instantiate(**wrong, logging=0)
    assert fmu.pointer is None
    assert [(status, category) for status, category, _ in fmu.log] == [(3, "logStatusError")]
    assert fmu.log[0][2].startswith(sentence)


def test_no_callbacks_and_no_instance_are_survived(library):
    from raw import ERROR, Callbacks

    assert library.instantiate(callbacks=False).pointer is None
    assert library.c.fmi2Instantiate(b"no logger", 1, b"{0}", None, byref(Callbacks()), 0, 1) is None
    nobody = library.instantiate(guid="{0}")
    for function in (*ALLOWED, "SerializeFMUstate", "DeSerializeFMUstate"):
        assert nobody.call(function, *arguments_of(function, c_void_p())) == ERROR
    library.c.fmi2FreeInstance(None)


def test_version_and_platform_are_those_of_the_standard(library):
    assert (library.c.fmi2GetVersion(), library.c.fmi2GetTypesPlatform()) == (b"2.0", b"default")


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda f: f.call("GetReal", None, c_size_t(1), byref(c_double())), "fmi2GetReal: references is NULL"),
        (lambda f: f.call("GetReal", byref(c_uint(0)), c_size_t(1), None), "fmi2GetReal: values is NULL"),
        (lambda f: f.call("SetInteger", byref(c_uint(2)), c_size_t(1), None), "fmi2SetInteger: values is NULL"),
        (lambda f: f.call("SetReal", None, c_size_t(1), byref(c_double())), "fmi2SetReal: references is NULL"),
        (
            lambda f: f.call("GetReal", byref(c_uint(1000)), c_size_t(1), byref(c_double())),
            "fmi2GetReal: there is no value reference 1000",
        ),
        (
            lambda f: f.call("SetReal", byref(c_uint(2**32 - 1)), c_size_t(1), byref(c_double())),
            "fmi2SetReal: there is no value reference 4294967295",
        ),
        (
            lambda f: f.call("GetReal", byref(c_uint(2)), c_size_t(1), byref(c_double())),
            "fmi2GetReal: offset is of type Integer",
        ),
        (lambda f: f.set(time_constant=2e-3), "fmi2SetReal: time_constant is a fixed parameter and cannot be set now"),
        (lambda f: f.set(y=1.0), "fmi2SetReal: y is a continuous output and cannot be set now"),
        (
            lambda f: f.call("GetString", byref(c_uint(0)), c_size_t(1), byref(c_char_p())),
            "fmi2GetString: time_constant is of type Real",
        ),
        (lambda f: f.step(math.nan), "fmi2DoStep: time = nan s is not allowed"),
        (lambda f: f.call("SetFMUstate", None), "fmi2SetFMUstate: state is NULL"),
        (lambda f: f.call("GetFMUstate", None), "fmi2GetFMUstate: state is NULL"),
        (
            lambda f: f.call("SerializedFMUstateSize", None, byref(c_size_t())),
            "fmi2SerializedFMUstateSize: state is NULL",
        ),
        (lambda f: f.call("SerializedFMUstateSize", f.save(), None), "fmi2SerializedFMUstateSize: size is NULL"),
        (
            lambda f: f.call("SerializeFMUstate", None, byref(c_double()), c_size_t(8)),
            "fmi2SerializeFMUstate: state is NULL",
        ),
        (
            lambda f: f.call("SerializeFMUstate", f.save(), None, c_size_t(10_000)),
            "fmi2SerializeFMUstate: bytes is NULL",
        ),
        (
            lambda f: f.call("DeSerializeFMUstate", None, c_size_t(8), byref(c_void_p())),
            "fmi2DeSerializeFMUstate: bytes is NULL",
        ),
        (
            lambda f: f.call("DeSerializeFMUstate", byref(c_double()), c_size_t(8), None),
            "fmi2DeSerializeFMUstate: state is NULL",
        ),
    ],
)
def test_a_wrong_argument_is_refused_with_the_reason(library, call, sentence):
    from raw import ERROR

    with library.instantiate() as fmu:
        fmu.begin()
        assert call(fmu) == ERROR
        assert (fmu.log[0][:2], fmu.log[0][2].startswith(sentence)) == ((3, "logStatusError"), True), fmu.log
        assert fmu.get("fault_code", "time_constant") == [998, 1e-3]
        assert fmu.reason() == fmu.log[0][2]
        assert fmu.step(0) == ERROR
        assert fmu.log[1][2].endswith(f"; stopped by an earlier fault: {fmu.reason()}")


@pytest.mark.parametrize(
    ("categories", "sentence"),
    [
        (byref(c_char_p(b"logNonsense")), "fmi2SetDebugLogging: there is no category logNonsense; there are "),
        (byref(c_char_p(None)), "fmi2SetDebugLogging: there is no category NULL; there are logStatusWarning, "),
        (None, "fmi2SetDebugLogging: categories is NULL"),
    ],
)
def test_a_wrong_log_category_is_refused_and_nothing_else_changes(library, categories, sentence):
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        assert fmu.call("SetDebugLogging", 0, c_size_t(1), categories) == ERROR
        fmu.begin(u=1.0)
        assert fmu.call("SetDebugLogging", 0, c_size_t(1), categories) == ERROR
        assert [(status, text[: len(sentence)]) for status, _, text in fmu.log] == 2 * [(ERROR, sentence)]
        assert (fmu.reason(), fmu.get("fault_code")) == (fmu.log[1][2], [0])
        assert (fmu.step(0), fmu.reason()) == (OK, "")
        fmu.set(u=5.0)
        assert fmu.step(1) == ERROR
        assert len(fmu.log) == 3, "it still logs"


def test_a_step_after_the_end_of_the_experiment_is_refused_and_the_run_can_end(library):
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        fmu.setup(0.0, 1e-3)
        fmu.call("EnterInitializationMode")
        fmu.call("ExitInitializationMode")
        assert [fmu.step(n) for n in range(4)] == [OK] * 4
        before = fmu.get("y", "steps")
        assert fmu.step(4) == ERROR
        said = "at t = 0.001 s: a step of 0.00025 s would end after the stop time of the experiment, 0.001 s"
        assert (fmu.log, fmu.reason()) == ([(ERROR, "logStatusError", said)], said)
        assert (fmu.get("y", "steps", "fault_code"), fmu.last_time()) == ([*before, 0], 1e-3)
        assert fmu.call("Terminate") == OK


@pytest.mark.parametrize(("steps", "h"), [(1000, 1e-3), (100_000, 1e-5), (3, 1.0 / 3.0)])
def test_a_host_that_sums_its_steps_reaches_the_stop_time(library, steps, h):
    """With a last step of what is left, be it 1e-17 s or 1e-12 s more than what should be left."""
    from raw import OK

    stop = 100.0 + steps * h
    with library.instantiate() as fmu:
        fmu.setup(100.0, stop)
        fmu.call("EnterInitializationMode")
        fmu.call("ExitInitializationMode")
        time = 100.0
        for _ in range(steps):
            assert fmu.call("DoStep", c_double(time), c_double(h), 1) == OK, fmu.log
            time += h
        assert time != stop or steps == 3, "the sum must differ from the product to show anything"
        if time < stop:
            assert fmu.call("DoStep", c_double(time), c_double(stop - time), 1) == OK, fmu.log
        assert fmu.call("Terminate") == OK


@pytest.mark.parametrize("h", [1e-9, 1e-17, 5e-324])
def test_a_step_of_next_to_nothing_changes_next_to_nothing(library, h):
    from raw import OK

    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        fmu.step(0)
        (y,) = fmu.get("y")
        assert fmu.call("DoStep", c_double(250e-6), c_double(h), 1) == OK
        assert fmu.get("y") == [pytest.approx(y, abs=2.0 * h / 1e-3 + 1e-16)]


@pytest.mark.parametrize(("start", "stop"), [(math.nan, None), (math.inf, None), (1.0, 0.5), (0.0, math.nan)])
def test_an_impossible_experiment_is_refused(library, start, stop):
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        assert fmu.setup(start, stop) == ERROR
        assert "time = " in fmu.log[0][2]
    with library.instantiate() as fmu:
        assert fmu.setup(1.0, 2.0) == OK


def test_one_wrong_reference_among_right_ones_sets_none(library):
    from raw import ERROR

    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        references, values = (c_uint * 2)(library.variables["u"][0], 999), (c_double * 2)(3.0, 3.0)
        assert fmu.call("SetReal", references, c_size_t(2), values) == ERROR
        assert fmu.get("u") == [1.0]


def test_outputs_follow_inputs_at_once_in_initialization_mode_only(library):
    from raw import OK

    with library.instantiate() as fmu:
        fmu.set(u=1.0)
        fmu.setup()
        fmu.call("EnterInitializationMode")
        levels = fmu.get("level")
        fmu.set(u=2.0)
        levels += fmu.get("level")
        fmu.call("ExitInitializationMode")
        fmu.set(u=3.0)
        levels += fmu.get("level")
        assert fmu.step(0) == OK
        assert levels + fmu.get("level") == [2.0, 4.0, 4.0, 6.0]


def test_a_tunable_parameter_may_change_during_the_run(library):
    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        fmu.set(gain=4.0)
        fmu.step(0)
        assert fmu.get("y") == [pytest.approx(4 * (1 - math.exp(-0.25)), rel=1e-12)]


def test_two_instances_in_turns_run_as_each_would_alone(library):
    def alone(sign):
        with library.instantiate() as fmu:
            fmu.begin(gain=2.0)
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
        assert (one.step(4), two.step(4)) == (3, 0)
        assert (len(one.log), len(two.log)) == (1, 0), "each instance has its own logger"


@pytest.mark.parametrize(
    ("on", "categories", "heard"),
    [
        (1, (), True),
        (0, (), False),
        (0, (b"logAll",), False),
        (1, (b"logAll",), True),
        (1, (b"logStatusError", b"logStatusFatal"), True),
        (1, (b"logStatusDiscard", b"logStatusWarning"), False),
    ],
)
def test_messages_go_by_category(library, on, categories, heard):
    from raw import OK

    with library.instantiate() as fmu:
        fmu.begin()
        chosen = (c_char_p * max(len(categories), 1))(*categories)
        assert fmu.call("SetDebugLogging", on, c_size_t(len(categories)), chosen) == OK
        fmu.set(u=5.0)
        fmu.step(0)
        assert [category for _, category, _ in fmu.log] == (["logStatusError"] if heard else [])


def test_every_declared_category_can_be_chosen(library):
    from raw import OK

    from fmi_export.log_categories import LOG_CATEGORIES

    with library.instantiate() as fmu:
        names = [name.encode() for name in LOG_CATEGORIES]
        assert fmu.call("SetDebugLogging", 1, c_size_t(len(names)), (c_char_p * len(names))(*names)) == OK


def test_nothing_is_logged_unless_asked_for(library):
    with library.instantiate(logging=0) as fmu:
        fmu.begin()
        fmu.set(u=5.0)
        assert (fmu.step(0), fmu.log) == (3, [])
        assert fmu.reason() == "u = 5 V is 100 % too much (%s %n)", "a host that asks is told all the same"
        assert fmu.get("fault_code") == [1]


def test_a_question_of_another_kind_or_without_room_for_the_answer_is_discarded(library):
    from raw import DISCARD, OK

    right = {"GetRealStatus": (2, c_double()), "GetBooleanStatus": (3, c_int()), "GetStringStatus": (1, c_char_p())}
    with library.instantiate() as fmu:
        fmu.begin()
        for function, (kind, room) in right.items():
            assert fmu.call(function, kind, byref(room)) == OK
            assert fmu.call(function, kind + 1, byref(room)) == DISCARD
            assert fmu.call(function, kind, None) == DISCARD


def test_nothing_is_done_where_there_is_no_state_to_free(library):
    from raw import OK

    with library.instantiate() as fmu:
        assert fmu.call("FreeFMUstate", None) == OK
        assert fmu.log == []


@pytest.mark.parametrize("names", [["y", "level"], ["level", "y"], [], ["y", "level", "u"] * 10])
def test_reals_are_read_and_set_in_any_order_and_number(library, names):
    """Lists of neighbours, of others, empty ones and those longer than there are variables, each twice."""
    from raw import OK

    with library.instantiate() as fmu:
        fmu.begin(u=2.0)
        fmu.step(0)
        expected = [dict(zip(("y", "level", "u"), fmu.get("y", "level", "u"), strict=True))[name] for name in names]
        references = (c_uint * len(names))(*(fmu.library.variables[name][0] for name in names))
        for _ in range(2):
            values = (c_double * len(names))()
            assert fmu.call("GetReal", references, c_size_t(len(names)), values) == OK
            assert list(values) == expected
        inputs = (c_uint * 30)(*[fmu.library.variables["u"][0]] * 30)
        for last in (1.0, 2.5):
            assert fmu.call("SetReal", inputs, c_size_t(30), (c_double * 30)(*[0.0] * 29, last)) == OK
            assert fmu.get("u") == [last]


def test_what_the_standard_leaves_optional_is_refused_without_harm(library):
    from raw import DISCARD, ERROR, OK

    with library.instantiate() as fmu:
        fmu.begin()
        one, value = byref(c_uint(0)), byref(c_double())
        assert fmu.call("GetDirectionalDerivative", one, c_size_t(1), one, c_size_t(1), value, value) == ERROR
        assert fmu.call("SetRealInputDerivatives", one, c_size_t(1), byref(c_int(1)), value) == ERROR
        assert fmu.call("GetRealOutputDerivatives", one, c_size_t(1), byref(c_int(1)), value) == ERROR
        assert fmu.call("CancelStep") == ERROR
        for function in ("GetStatus", "GetRealStatus", "GetIntegerStatus", "GetBooleanStatus", "GetStringStatus"):
            assert fmu.call(function, 0, byref(c_double())) == DISCARD
        assert len(fmu.log) == 9
        assert fmu.step(0) == OK


def test_a_fault_is_no_end_that_the_model_wants(library):
    """Hosts take fmi2Terminated for success: FMPy, fmusim, PyFMI and others stop without a word."""
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        fmu.begin()
        fmu.step(0)
        ended = c_int(-1)
        assert (fmu.call("GetBooleanStatus", 3, byref(ended)), ended.value) == (OK, 0)
        fmu.set(u=5.0)
        assert fmu.step(1) == ERROR
        assert fmu.last_time() == 250e-6
        assert (fmu.call("GetBooleanStatus", 3, byref(ended)), ended.value) == (OK, 0)


@pytest.mark.parametrize("h", [0.0, -1e-3, math.nan, math.inf])
def test_a_wrong_step_size_is_an_error_with_the_reason(library, h):
    from raw import ERROR

    with library.instantiate() as fmu:
        fmu.begin()
        assert fmu.call("DoStep", c_double(0.5), c_double(h), 1) == ERROR
        sentence = f"step size = {h:g} s is not allowed; it must be > 0 s and finite"
        assert fmu.log == [(ERROR, "logStatusError", f"at t = 0.5 s: {sentence}")]
        assert (fmu.reason(), fmu.get("fault_code"), fmu.last_time()) == (sentence, [999], 0.0)


def test_out_of_the_error_state_leads_a_state_from_before_or_a_reset(library):
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        fmu.step(0)
        saved, before = fmu.save(), fmu.get("y", "steps")
        fmu.set(u=5.0)
        assert (fmu.step(1), fmu.step(1), fmu.call("Terminate")) == (ERROR, ERROR, ERROR)
        assert fmu.get("y", "steps", "fault_code") == [*before, 1], "the last good outputs"
        assert fmu.call("SetFMUstate", saved) == OK
        assert (fmu.reason(), fmu.step(1), fmu.get("steps", "fault_code")) == ("", OK, [2, 0])
        assert fmu.call("Reset") == OK
        fmu.begin()
        assert (fmu.reason(), fmu.step(0), fmu.get("steps")) == ("", OK, [1])
