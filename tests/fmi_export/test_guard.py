"""The guard before PythonFMU's library: what hosts get wrong is refused with a reason, and a fault is no end.

A host is a process of its own, which calls the library as a C host does. It returns plain data, which the tests read.
"""

import math
import re
import zipfile
from pathlib import Path

import pytest

STATES = ("instantiated", "initialization mode", "step complete", "terminated", "error")
READABLE, SETTABLE, ASKABLE = STATES[1:], STATES[:3], STATES[2:]
# In which states a call is allowed, after the tables of calling sequences of the standard; the last three are answered
# in the error state too, where there is most to ask.
ALLOWED = {
    "SetDebugLogging": STATES,
    "SetupExperiment": STATES[:1],
    "EnterInitializationMode": STATES[:1],
    "ExitInitializationMode": STATES[1:2],
    "DoStep": STATES[2:3],
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
    "GetRealStatus": ASKABLE,
    "GetBooleanStatus": ASKABLE,
    "GetStringStatus": ASKABLE,
}


@pytest.fixture(scope="module")
def fmu(build_fmu, lag, tmp_path_factory) -> Path:
    """Folder of the extracted FMU of the lag."""
    folder = tmp_path_factory.mktemp("guarded")
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        archive.extractall(folder)
    return folder


# Where the resources are ---------------------------------------------------------------------------------------------


def try_locations(folder: str, place: str) -> dict:
    import os
    import shutil
    from pathlib import Path

    from raw import Library

    resources = Path(place) / "resources"
    shutil.copytree(Path(folder) / "resources", resources)
    library = Library(Path(folder))
    uri = resources.as_uri()
    encoded = uri.removeprefix("file://")
    right = [uri, f"{uri}/", f"file:{encoded}", f"file://localhost{encoded}", f"FILE://LocalHost{encoded}//"]
    right += [f"file://{resources}", str(resources), f"{resources}/../resources"]
    os.chdir(place)
    right += ["resources", "./resources/", "file:resources"]
    steps = {}
    for form in right:
        fmu = library.instantiate(resources=form)
        os.chdir("/")  # the folder stays in Python's list of folders
        steps[form] = fmu.pointer and fmu.begin(u=1.0).step(0)
        fmu.free()
        os.chdir(place)

    percent = Path(place) / "a%20b"
    shutil.copytree(resources, percent)
    for k, missing in enumerate(("slavemodule.txt", "probe_lag_fmu.py", "model.bin")):
        shutil.copytree(resources, Path(place) / f"broken {k}")
        (Path(place) / f"broken {k}" / missing).unlink()
    damaged = Path(place) / "damaged"
    shutil.copytree(resources, damaged)
    data = bytearray((damaged / "model.bin").read_bytes())
    data[200] ^= 1
    (damaged / "model.bin").write_bytes(data)
    broken = [str(Path(place) / f"broken {k}") for k in range(3)]
    wrong = [
        None,
        "",
        "/nowhere",
        "file:///nowhere%20else/",
        "file://server/share",
        "https://server/share",
        "data:,abc",
    ]
    wrong += ["/" + 10000 * "x", str(percent), *broken, str(damaged)]
    refusals = {}
    for form in wrong:
        fmu = library.instantiate(resources=form, logging=0)
        refusals[str(form)[-60:]] = [fmu.pointer, *fmu.log]
    return {"steps": steps, "refusals": refusals}


@pytest.fixture(scope="module")
def locations(fmu, run_python, tmp_path_factory):
    place = tmp_path_factory.mktemp("a b") / "Größe 100% #1? €😀"
    return run_python(try_locations, folder=fmu, place=place)


def test_a_location_leads_to_the_resources_in_every_form(locations):
    assert len(locations["steps"]) == 11
    assert set(locations["steps"].values()) == {0}, locations["steps"]


@pytest.mark.parametrize(
    ("location", "sentence"),
    [
        ("None", "the host gave no resource location"),
        ("", "the host gave no resource location"),
        ("/nowhere", "cannot read /nowhere/model.bin: No such file or directory"),
        ("file:///nowhere%20else/", "cannot read /nowhere else/model.bin: No such file or directory"),
        ("file://server/share", "the resource location file://server/share is not on this machine"),
        ("https://server/share", "the resource location https://server/share is not on this machine"),
        ("data:,abc", "a data URI with the resources must be in base64: data:;base64,..."),
        (60 * "x", "cannot read /xxxx"),
        ("/a%20b", "PythonFMU reads no folder with %%20 in its path: "),  # for a printf
        ("/broken 0", "slavemodule.txt: No such file or directory"),
        ("/broken 1", "probe_lag_fmu.py: No such file or directory"),
        ("/broken 2", "model.bin: No such file or directory"),
        ("/damaged", "resources/model.bin does not fit: it is damaged"),
    ],
)
def test_a_location_without_resources_is_refused_with_the_reason(locations, location, sentence):
    (refusal,) = (
        value
        for form, value in locations["refusals"].items()
        if form == location or (len(location) > 4 and location[0] == "/" and form.endswith(location))
    )
    pointer, (status, category, text) = refusal
    assert (pointer, status, category) == (None, 3, "logStatusError")
    assert sentence in text


# What a host may call ------------------------------------------------------------------------------------------------


def try_instances(folder: str, functions: list) -> dict:
    from ctypes import byref
    from pathlib import Path

    from raw import Callbacks, Library

    library = Library(Path(folder))
    answers = {}
    for wrong in ({"guid": "{0}"}, {"guid": None}, {"kind": 0}, {"name": b""}, {"name": None}):
        fmu = library.instantiate(**wrong, logging=0)
        answers[str(wrong)] = [fmu.pointer, *fmu.log]
    no_logger = library.c.fmi2Instantiate(b"no logger", 1, b"{0}", None, byref(Callbacks()), 0, 1)
    answers["no callbacks"] = [library.instantiate(callbacks=False).pointer, no_logger]
    nobody = library.instantiate(guid="{0}")
    answers["no instance"] = [nobody.call(function, *6 * [None]) for function in functions]
    library.c.fmi2FreeInstance(None)
    answers["versions"] = [library.c.fmi2GetVersion().decode(), library.c.fmi2GetTypesPlatform().decode()]
    return answers


def test_an_instance_that_cannot_be_made_is_none_and_the_log_says_why(fmu, run_python):
    others = ["SerializeFMUstate", "DeSerializeFMUstate", "GetIntegerStatus", "CancelStep"]
    answers = run_python(try_instances, folder=fmu, functions=[*ALLOWED, *others])
    assert set(answers.pop("no instance")) == {3}
    assert answers.pop("versions") == ["2.0", "default"]
    assert answers.pop("no callbacks") == [None, None]
    sentences = {
        "{'guid': '{0}'}": "the modelDescription.xml has guid {0}, but resources/model.bin belongs to {",
        "{'guid': None}": "the modelDescription.xml has guid NULL",
        "{'kind': 0}": "this is an FMU for co-simulation, not for model exchange",
        "{'name': b''}": "an instance needs a name",
        "{'name': None}": "an instance needs a name",
    }
    assert answers.keys() == sentences.keys()
    for wrong, (pointer, (status, category, text)) in answers.items():
        assert (pointer, status, category) == (None, 3, "logStatusError"), wrong
        assert text.startswith(sentences[wrong])


def try_states(folder: str, allowed: dict, states: list) -> list:
    from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
    from pathlib import Path

    from raw import Library

    library = Library(Path(folder))
    rows = []
    for function in allowed:
        for state in states:
            fmu = library.instantiate()
            if state != "instantiated":
                fmu.setup()
                fmu.call("EnterInitializationMode")
            if state in ("step complete", "terminated", "error"):
                fmu.call("ExitInitializationMode")
            if state == "terminated":
                fmu.call("Terminate")
            elif state == "error":
                fmu.call("SetString", byref(c_uint(0)), c_size_t(1), byref(c_char_p(b"")))
            saved, nothing = fmu.save(), (None, c_size_t(0), None)
            arguments = {
                "SetDebugLogging": (1, c_size_t(0), None),
                "SetupExperiment": (0, c_double(0.0), c_double(0.0), 0, c_double(0.0)),
                "DoStep": (c_double(0.0), c_double(250e-6), 1),
                "GetFMUstate": (byref(c_void_p()),),
                "FreeFMUstate": (byref(c_void_p()),),
                "SetFMUstate": (saved,),
                "SerializedFMUstateSize": (saved, byref(c_size_t())),
                "GetRealStatus": (2, byref(c_double())),
                "GetBooleanStatus": (3, byref(c_int())),
                "GetStringStatus": (1, byref(c_char_p())),
            }.get(function, nothing if function[:3] in ("Get", "Set") else ())
            del fmu.log[:]
            status = fmu.call(function, *arguments)
            said = fmu.log[0][2] if fmu.log else ""
            code = [] if (state == "instantiated" and not said) or function == "Reset" else fmu.get("fault_code")
            rows.append([function, state, status, said, code, fmu.call("FreeFMUstate", byref(saved))])
            fmu.free()
    return rows


def test_a_call_is_allowed_in_the_states_of_the_standard_only(fmu, run_python):
    rows = run_python(try_states, folder=fmu, allowed=ALLOWED, states=STATES)
    assert len(rows) == len(ALLOWED) * len(STATES)
    for function, state, status, said, code, freed in rows:
        assert freed == 0
        if state in ALLOWED[function]:
            assert (status, said) == (0, ""), (function, state)
        else:
            assert status == 3, (function, state)
            assert said.startswith(f"fmi2{function} is not allowed in state '{state}'")
            assert all(f"'{name}'" in said for name in ALLOWED[function])
            assert code == [998]


def try_arguments(folder: str) -> list:
    import math
    from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint
    from pathlib import Path

    from raw import Library

    one = c_size_t(1)
    library = Library(Path(folder))
    calls = {
        "references": lambda f: f.call("GetReal", None, one, byref(c_double())),
        "values": lambda f: f.call("GetReal", byref(c_uint(0)), one, None),
        "get 1000": lambda f: f.call("GetReal", byref(c_uint(1000)), one, byref(c_double())),
        "set -1": lambda f: f.call("SetReal", byref(c_uint(2**32 - 1)), one, byref(c_double())),
        "Real of Integer": lambda f: f.call("GetReal", byref(c_uint(2)), one, byref(c_double())),
        "Integer of Real": lambda f: f.call("GetInteger", byref(c_uint(5)), one, byref(c_int())),
        "Boolean of Integer": lambda f: f.call("SetBoolean", byref(c_uint(2)), one, byref(c_int())),
        "get String": lambda f: f.call("GetString", byref(c_uint(0)), one, byref(c_char_p())),
        "set String": lambda f: f.call("SetString", byref(c_uint(3)), one, byref(c_char_p(b"1"))),
        "fixed": lambda f: f.set(time_constant=2e-3),
        "output": lambda f: f.set(y=1.0),
        "time": lambda f: f.step(math.nan),
        "SetFMUstate": lambda f: f.call("SetFMUstate", None),
        "GetFMUstate": lambda f: f.call("GetFMUstate", None),
        "DeSerialize": lambda f: f.call("DeSerializeFMUstate", None, one, None),
        "to nowhere": lambda f: f.call("DeSerializeFMUstate", byref(c_double()), one, None),
        "size of nothing": lambda f: f.call("SerializedFMUstateSize", None, byref(c_size_t())),
        "size": lambda f: f.call("SerializedFMUstateSize", f.save(), None),
        "bytes of nothing": lambda f: f.call("SerializeFMUstate", None, byref(c_double()), one),
        "bytes": lambda f: f.call("SerializeFMUstate", f.save(), None, one),
        "set references": lambda f: f.call("SetReal", None, one, byref(c_double())),
    }
    rows = []
    for name, call in calls.items():
        fmu = library.instantiate().begin(u=1.0)
        status, reason = call(fmu), c_char_p()
        fmu.call("GetStringStatus", 1, byref(reason))
        rows.append([name, status, fmu.log, fmu.get("fault_code", "time_constant"), reason.value.decode(), fmu.step(0)])
        fmu.call("Reset")
        rows[-1].append(fmu.begin(u=1.0).step(0))
        fmu.free()
    return rows


def test_a_wrong_argument_is_refused_before_python_sees_it(fmu, run_python):
    sentences = {
        "references": "fmi2GetReal: references is NULL",
        "values": "fmi2GetReal: values is NULL",
        "get 1000": "fmi2GetReal: there is no value reference 1000",
        "set -1": "fmi2SetReal: there is no value reference 4294967295",
        "Real of Integer": "fmi2GetReal: offset is of type Integer",
        "Integer of Real": "fmi2GetInteger: y is of type Real",
        "Boolean of Integer": "fmi2SetBoolean: offset is of type Integer",
        "get String": "fmi2GetString: time_constant is of type Real",
        "set String": "fmi2SetString: u is of type Real",
        "fixed": "fmi2SetReal: time_constant is a fixed parameter and cannot be set now",
        "output": "fmi2SetReal: y is a continuous output and cannot be set now",
        "time": "fmi2DoStep: time = nan s is not allowed; it must be a finite number",
        "SetFMUstate": "fmi2SetFMUstate: state is NULL",
        "GetFMUstate": "fmi2GetFMUstate: state is NULL",
        "DeSerialize": "fmi2DeSerializeFMUstate: bytes is NULL",
        "to nowhere": "fmi2DeSerializeFMUstate: state is NULL",
        "size of nothing": "fmi2SerializedFMUstateSize: state is NULL",
        "size": "fmi2SerializedFMUstateSize: size is NULL",
        "bytes of nothing": "fmi2SerializeFMUstate: state is NULL",
        "bytes": "fmi2SerializeFMUstate: bytes is NULL",
        "set references": "fmi2SetReal: references is NULL",
    }
    rows = run_python(try_arguments, folder=fmu)
    assert [row[0] for row in rows] == list(sentences)
    for name, status, log, values, reason, next_step, after_reset in rows:
        assert status == 3, name
        assert log[0] == [3, "logStatusError", sentences[name]]
        assert values == [998, 1e-3]
        assert reason == sentences[name]
        assert next_step == 3, "the error state stays"
        assert after_reset == 0


def try_questions(folder: str) -> list:
    from ctypes import byref, c_char_p, c_double, c_int
    from pathlib import Path

    from raw import Library

    fmu = Library(Path(folder)).instantiate().begin(u=1.0)
    right = {"GetRealStatus": (2, c_double()), "GetBooleanStatus": (3, c_int()), "GetStringStatus": (1, c_char_p())}
    rows = []
    for function, (kind, room) in right.items():
        asked = ((kind, byref(room)), (kind + 1, byref(room)), (kind, None))
        rows.append([fmu.call(function, *arguments) for arguments in asked])
    fmu.free()
    return rows


def test_a_question_of_another_kind_or_without_room_for_the_answer_is_discarded(fmu, run_python):
    assert run_python(try_questions, folder=fmu) == [[0, 2, 2]] * 3


# Faults --------------------------------------------------------------------------------------------------------------


def try_faults(folder: str) -> list:
    from ctypes import byref, c_char_p, c_double, c_int
    from pathlib import Path

    from raw import Library

    library = Library(Path(folder))
    rows = []
    for u, h in ((5.0, 250e-6), (-7.0, 250e-6), (11.0, 250e-6), (1.0, -1e-3), (1.0, 0.0), (1.0, float("inf"))):
        fmu = library.instantiate(logging=0).begin(u=1.0)
        fmu.step(0)
        saved, before = fmu.save(), fmu.get("y")
        fmu.set(u=u)
        status = fmu.call("DoStep", c_double(250e-6), c_double(h), 1)
        terminated, reason = c_int(7), c_char_p()
        asked = [fmu.call("GetBooleanStatus", 3, byref(terminated)), fmu.call("GetStringStatus", 1, byref(reason))]
        text = reason.value.decode()
        row = [status, *asked, terminated.value, *fmu.get("fault_code"), text, fmu.get("y") == before, fmu.last_time()]
        fmu.call("SetFMUstate", saved)
        fmu.set(u=1.0)
        row += [
            fmu.step(1),
            *fmu.get("fault_code"),
            fmu.call("GetStringStatus", 1, byref(reason)),
            reason.value.decode(),
        ]
        rows.append([*row, fmu.log])
        fmu.free()
    return rows


def test_a_fault_is_an_error_with_a_reason_and_never_an_end(fmu, run_python):
    rows = run_python(try_faults, folder=fmu)
    codes = [1, 100005, 1003, 999, 999, 999]
    texts = ["u = 5 V is 100 % too much", "y is no longer a finite number", "u = 11 V is not allowed"]
    texts += [f"step size = {h} s is not allowed" for h in ("-0.001", "0", "inf")]
    for row, code, text in zip(rows, codes, texts, strict=True):
        assert row[:5] == [3, 0, 0, 0, code]
        assert row[5].startswith(text)
        assert row[6:8] == [True, 250e-6], "outputs and time are those of the last step that was done"
        assert row[8:12] == [0, 0, 0, ""], "a state from before the fault leads out"
        assert row[12] == [], "logging is off"


def simulate(path: str) -> list:
    import fmpy

    answers = []
    for u in (1.0, 5.0):
        try:
            answers.append(len(fmpy.simulate_fmu(path, stop_time=0.01, output_interval=1e-3, start_values={"u": u})))
        except Exception as error:
            answers.append(str(error))
    return answers


def test_a_simulation_with_a_fault_does_not_look_like_one_that_ended(build_fmu, lag, run_python):
    ended, failed = run_python(simulate, path=build_fmu(lag))
    assert ended == 11
    assert "(error)" in failed


def try_initialisation(folder: str) -> list:
    from ctypes import byref, c_char_p
    from pathlib import Path

    from raw import Library

    library = Library(Path(folder))
    fmu = library.instantiate()
    fmu.set(u=11.0)
    fmu.setup()
    fmu.call("EnterInitializationMode")
    statuses = fmu.get("fault_code")
    fmu.set(u=1.0)
    statuses += [*fmu.get("fault_code"), fmu.call("ExitInitializationMode"), fmu.step(0)]
    fmu.call("Reset")
    fmu.set(u=11.0)
    fmu.setup()
    fmu.call("EnterInitializationMode")
    statuses += fmu.get("fault_code")
    reason = c_char_p()
    statuses += [fmu.call("ExitInitializationMode"), fmu.call("GetStringStatus", 1, byref(reason)), fmu.step(0)]
    answer = [statuses, fmu.log, reason.value.decode()]
    fmu.free()
    return answer


def test_a_fault_in_initialization_mode_can_be_put_right_until_its_end(fmu, run_python):
    statuses, log, reason = run_python(try_initialisation, folder=fmu)
    assert statuses == [1003, 0, 0, 0, 1003, 3, 0, 3]
    sentence = "initialisation: u = 11 V is not allowed; it must be >= -10 and <= 10 V"
    assert log[:3] == [
        [1, "logStatusWarning", sentence],
        [1, "logStatusWarning", sentence],
        [3, "logStatusError", sentence],
    ]
    assert reason == sentence.removeprefix("initialisation: ")


def try_experiments(folder: str) -> list:
    import math
    from pathlib import Path

    from raw import Library

    library = Library(Path(folder))
    rows = []
    for start, stop in ((math.nan, None), (math.inf, None), (1.0, 0.5), (0.0, math.nan)):
        with library.instantiate() as fmu:
            rows.append([fmu.setup(start, stop), fmu.log[0][2]])
    with library.instantiate() as fmu:
        fmu.setup(0.0, 1e-3)
        fmu.call("EnterInitializationMode")
        fmu.call("ExitInitializationMode")
        rows.append([*(fmu.step(n) for n in range(5)), fmu.log[0][2], *fmu.get("fault_code"), fmu.call("Terminate")])
    return rows


def test_an_impossible_experiment_is_refused_and_a_step_beyond_it_harmless(fmu, run_python):
    *wrong, steps = run_python(try_experiments, folder=fmu)
    for status, sentence in wrong:
        assert status == 3
        assert "time = " in sentence
    *statuses, sentence, code, terminated = steps
    assert statuses == [0, 0, 0, 0, 3]
    assert sentence == "at t = 0.001 s: a step of 0.00025 s would end after the stop time of the experiment, 0.001 s"
    assert (code, terminated) == (0, 0), "the instance lives on"


# Logging -------------------------------------------------------------------------------------------------------------


def try_logging(folder: str) -> dict:
    from ctypes import byref, c_char_p, c_size_t
    from pathlib import Path

    from raw import Library

    library = Library(Path(folder))
    one, two = library.instantiate(name=b"one"), library.instantiate(name=b"two")
    one.begin(u=1.0)
    two.begin(u=1.0)
    answers = {}
    for text in (None, b"logNonsense"):
        answers[str(text)] = [one.call("SetDebugLogging", 1, c_size_t(1), byref(c_char_p(text))), one.step(0)]
    answers["NULL"] = [one.call("SetDebugLogging", 1, c_size_t(1), None), one.step(1)]
    answers["declined"] = [text for _, _, text in one.log]
    del one.log[:]
    one.call("SetDebugLogging", 1, c_size_t(1), byref(c_char_p(b"logStatusError")))
    one.set(u=4.0)  # a warning
    two.set(u=4.0)
    answers["steps"] = [one.step(2), two.step(0)]
    one.set(u=5.0)
    answers["steps"] += [one.step(3)]
    answers["one"], answers["two"] = one.log, two.log
    one.free()
    two.free()
    return answers


def test_an_instance_logs_to_its_own_host_what_that_wants_to_hear(fmu, run_python):
    answers = run_python(try_logging, folder=fmu)
    assert answers["None"] == answers["b'logNonsense'"] == answers["NULL"] == [3, 0], "a wrong category does no harm"
    assert answers["declined"][0].startswith(
        "fmi2SetDebugLogging: there is no category NULL; there are logStatusWarning, "
    )
    assert answers["declined"][1].startswith("fmi2SetDebugLogging: there is no category logNonsense; ")
    assert answers["declined"][2] == "fmi2SetDebugLogging: categories is NULL"
    assert answers["steps"] == [0, 0, 3]
    assert answers["one"] == [[3, "logStatusError", "at t = 0.00075 s: u = 5 V is 100 %% too much (%%s %%n)"]]
    warning = "at t = 0.00025 s: high: u = 4 V is above 3 V, half of what is allowed (100 %%)"
    assert answers["two"] == [[1, "logStatusWarning", warning]]


# Saved states --------------------------------------------------------------------------------------------------------


def try_states_of_others(folder: str, other: str) -> dict:
    import random
    from ctypes import byref, c_size_t, c_void_p, create_string_buffer
    from pathlib import Path

    from raw import Library

    fmu, foreign = Library(Path(folder)).instantiate(), Library(Path(other)).instantiate()
    fmu.begin(u=2.0)
    fmu.step(0)
    saved = fmu.save()
    text = fmu.serialise(saved)
    rng = random.Random(400)
    flips = []
    for bit in rng.sample(range(8 * len(text)), 400):
        damaged = bytearray(text)
        damaged[bit // 8] ^= 1 << bit % 8
        flips.append(fmu.deserialise(bytes(damaged))[0])
        fmu.call("SetFMUstate", saved)
    answers = {"flips": flips}
    texts = {"cut": text[:-1], "empty": b"", "longer": text + b"0", "rubbish": b"rubbish", "foreign": b""}
    texts["foreign"] = foreign.serialise(foreign.save())
    for name, wrong in texts.items():
        del fmu.log[:]
        status, state = fmu.deserialise(wrong)
        answers[name] = [status, state.value, fmu.log[0][2]]
        fmu.call("SetFMUstate", saved)
    del fmu.log[:]
    answers["pointer"] = [fmu.call("SetFMUstate", foreign.save()), fmu.log[0][2]]
    fmu.call("SetFMUstate", saved)
    answers["short"] = [fmu.call("SerializeFMUstate", saved, create_string_buffer(8), c_size_t(8)), fmu.log[-1][2]]
    fmu.call("SetFMUstate", saved)
    again = fmu.save(saved)
    answers["overwritten"] = again.value == saved.value
    status, copy = fmu.deserialise(text)
    rows = []
    for state in (again, copy):
        fmu.call("SetFMUstate", state)
        fmu.set(u=3.0)
        rows.append([fmu.step(1), *fmu.get("y", "steps"), fmu.last_time()])
    answers["runs"] = rows
    frees = [fmu.call("FreeFMUstate", byref(saved)), saved.value, fmu.call("FreeFMUstate", byref(saved))]
    frees += [fmu.call("FreeFMUstate", byref(c_void_p())), fmu.call("FreeFMUstate", None)]
    answers["freed"] = frees
    fmu.free()
    foreign.free()
    return answers


def test_damaged_or_foreign_states_are_refused(fmu, build_fmu, run_python, tmp_path):
    from rig import ACTUATOR, ACTUATOR_CONSTANTS

    with zipfile.ZipFile(build_fmu(ACTUATOR, ACTUATOR_CONSTANTS)) as archive:
        archive.extractall(tmp_path)
    answers = run_python(try_states_of_others, folder=fmu, other=tmp_path)
    assert answers["flips"] == 400 * [3]
    whole, ours = "fmi2DeSerializeFMUstate: the bytes are not whole", "the state belongs to another FMU"
    assert answers["cut"] == answers["longer"] == [3, None, whole]
    for name in ("empty", "rubbish", "foreign"):
        assert answers[name] == [3, None, f"fmi2DeSerializeFMUstate: {ours}"]
    assert answers["pointer"] == [3, f"fmi2SetFMUstate: {ours}"]
    assert answers["short"][0] == 3
    assert re.fullmatch(r"fmi2SerializeFMUstate: a state takes \d+ bytes, not 8", answers["short"][1])
    assert answers["overwritten"]
    first, second = answers["runs"]
    assert first == second
    assert first[0] == 0
    share = 1.0 - math.exp(-0.25)
    assert first[1:] == [pytest.approx(2.0 * share + share * (3.0 - 2.0 * share)), 2, 5e-4]
    assert answers["freed"] == [0, None, 0, 0, 0]


# Python that fails ---------------------------------------------------------------------------------------------------


def reset_without_resources(folder: str) -> list:
    import shutil
    from pathlib import Path

    from raw import Library

    with Library(Path(folder)).instantiate().begin(u=1.0) as fmu:
        answer = [fmu.step(0)]
        shutil.rmtree(folder)
        return [*answer, fmu.step(1), fmu.call("Reset"), fmu.begin(u=1.0).step(0), fmu.get("steps"), fmu.log]


def test_a_reset_needs_no_resources(fmu, run_python, tmp_path):
    import shutil

    copy = shutil.copytree(fmu, tmp_path / "copy")
    assert run_python(reset_without_resources, folder=copy) == [0, 0, 0, 0, [1], []]


# The library ---------------------------------------------------------------------------------------------------------


def test_the_guard_has_the_functions_of_the_standard_and_no_python(build_fmu, lag):
    from binaries import read

    from fmi_export.building.native.compiler import PLATFORMS, host_platform

    here = host_platform()
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        names = {name for name in archive.namelist() if name.startswith("binaries/")}
        suffix = PLATFORMS[here][0]
        assert names == {f"binaries/{here}/probe_lag{suffix}", f"binaries/{here}/probe_lag_pythonfmu{suffix}"}
        (guard,) = read(archive.read(f"binaries/{here}/probe_lag{suffix}"))
        (pythonfmu,) = read(archive.read(f"binaries/{here}/probe_lag_pythonfmu{suffix}"))
    standard = {name for name in pythonfmu.exports if name.startswith("fmi2")}
    assert guard.exports == standard
    assert len(standard) == 34
    assert not [name for name in guard.imports if name.startswith(("Py", "_Py"))]
