"""The guarded FMU of flavour python and the native one answer the same calls alike: statuses, values, messages."""

import zipfile

import pytest


@pytest.fixture(scope="module")
def flavours(build_fmu, create_once, lag, tmp_path_factory):
    """Folders of the two FMUs of the lag, extracted."""
    import numpy as np

    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")
    from fmi_export.building.native.package import build_native_fmu, native_guid

    guid = native_guid(lag, np.zeros(1)).strip("{}")
    native = create_once(f"agreement-{guid}", lambda folder: build_native_fmu(lag, np.zeros(1), folder))
    folders = {}
    for name, path in (("native", native / f"{lag.name}.fmu"), ("python", build_fmu(lag))):
        folders[name] = tmp_path_factory.mktemp(name)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folders[name])
    return folders


def make_same_calls(native: str, python: str, runs: int, calls: int) -> dict:
    """Make random calls of both FMUs; return the first differences, and how often each status was answered."""
    import random
    from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
    from pathlib import Path

    from raw import Library

    libraries = [Library(Path(native)), Library(Path(python))]
    rng = random.Random(2006)
    numbers = (0.0, 1.0, -3.0, 4.0, 5.0, -7.0, 11.0, 2.5e-4, 1e300, float("nan"), float("inf"))
    one = c_size_t(1)

    def life(fmu, u):
        statuses = [fmu.call("SetupExperiment", 0, c_double(0), c_double(0), 0, c_double(0))]
        statuses += [fmu.set(u=u), fmu.call("EnterInitializationMode"), fmu.call("ExitInitializationMode")]
        return [*statuses, fmu.step(0), fmu.step(1)]

    def set_value(fmu, kind, reference, value):
        number = c_double(value) if kind == "Real" else c_int(int(value) if abs(value) < 9 else 7)
        return fmu.call(f"Set{kind}", byref(c_uint(reference)), one, byref(number))

    def get_value(fmu, kind, reference):
        number = c_double(0.5) if kind == "Real" else c_int(77)
        return [fmu.call(f"Get{kind}", byref(c_uint(reference)), one, byref(number)), repr(number.value)]

    def ask(fmu):
        time, ended, reason = c_double(0.5), c_int(7), c_char_p(b"")
        answers = [fmu.call("GetRealStatus", 2, byref(time)), fmu.call("GetBooleanStatus", 3, byref(ended))]
        return [*answers, fmu.call("GetStringStatus", 1, byref(reason)), time.value, ended.value, reason.value.decode()]

    def roundtrip(fmu, state):
        status, copy = fmu.deserialise(fmu.serialise(state))
        return [status, fmu.call("SetFMUstate", copy), fmu.call("FreeFMUstate", byref(copy))]

    def draw():
        """One call, as a function of the instance and its saved state."""
        kind, reference = rng.choice(("Real", "Integer", "Boolean")), rng.choice((*range(11), 11, 2**32 - 1))
        if rng.random() < 0.7:  # mostly right
            kind, reference = rng.choice((("Real", 3), ("Real", 1), ("Real", 0), ("Integer", 2), ("Boolean", 4)))
        outputs = (("Real", 5), ("Real", 6), ("Integer", 7), ("Boolean", 8), ("Boolean", 9), ("Integer", 10))
        readable = rng.choice(outputs)
        value, n = rng.choice(numbers), rng.randrange(6)
        step = rng.choice((250e-6, 250e-6, 250e-6, 1e-3, 0.0, -1.0, float("nan")))
        categories = (c_char_p * 1)(rng.choice((b"logAll", b"logStatusWarning", b"logStatusError", b"nonsense")))
        return rng.choice(
            (
                *4 * (lambda f, s: set_value(f, kind, reference, value),),
                *2 * (lambda f, s: get_value(f, *readable),),
                lambda f, s: get_value(f, kind, reference),
                *6 * (lambda f, s: f.call("DoStep", c_double(n * 250e-6), c_double(step), 1),),
                *2 * (lambda f, s: [f.call("Reset"), *life(f, value)],),
                lambda f, s: f.call("SetupExperiment", 0, c_double(0), c_double(value), n % 2, c_double(1e-3)),
                lambda f, s: f.call("EnterInitializationMode"),
                lambda f, s: f.call("ExitInitializationMode"),
                lambda f, s: f.call("Terminate"),
                lambda f, s: f.call("GetFMUstate", byref(s)),
                *2 * (lambda f, s: f.call("SetFMUstate", s),),
                lambda f, s: roundtrip(f, s) if s.value else 0,
                lambda f, s: f.call("SetDebugLogging", n > 0, c_size_t(n % 2), categories),
                lambda f, s: f.call("SetString", byref(c_uint(n)), one, byref(c_char_p(b"1"))),
                lambda f, s: f.call("CancelStep"),
                lambda f, s: f.call("GetIntegerStatus", n, None),
                *2 * (lambda f, s: ask(f),),
            )
        )

    differences, statuses = [], {}
    for run in range(runs):
        fmus, states = [library.instantiate() for library in libraries], [c_void_p(), c_void_p()]
        assert [life(fmu, 1.0) for fmu in fmus] == [[0] * 6] * 2
        for k in range(calls):
            call = draw()
            answers = [call(fmu, state) for fmu, state in zip(fmus, states, strict=True)]
            answers = [[answer, fmu.log[:]] for answer, fmu in zip(answers, fmus, strict=True)]
            status = answers[0][0][0] if isinstance(answers[0][0], list) else answers[0][0]
            statuses[str(status)] = statuses.get(str(status), 0) + 1
            if answers[0] != answers[1]:
                differences.append([run, k, *answers])
                break
            for fmu in fmus:
                del fmu.log[:]
        for fmu in fmus:
            fmu.free()
    return {"differences": differences[:5], "statuses": statuses}


def test_both_flavours_answer_the_same_calls_alike(flavours, run_python):
    found = run_python(make_same_calls, **flavours, runs=60, calls=60)
    assert found["differences"] == []
    assert found["statuses"].keys() >= {"0", "2", "3"}
    assert found["statuses"]["0"] > 500
