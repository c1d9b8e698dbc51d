"""What calls of the slave are given: references, values and other arguments, right and wrong."""

import math
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest
from raw import DISCARD, ERROR, OK

from tests.support.messages import assert_names

REAL, INTEGER, BOOLEAN, STRING = range(4)
NULL = None


@pytest.mark.parametrize(
    ("way", "kind", "references", "values", "facts"),
    [
        ("Get", REAL, NULL, [0.0], ("references", "NULL")),
        ("Set", REAL, NULL, [0.0], ("references", "NULL")),
        ("Get", REAL, [0], NULL, ("values", "NULL")),
        ("Set", INTEGER, [2], NULL, ("values", "NULL")),
        ("Get", REAL, [1000], [0.0], ("1000",)),
        ("Set", REAL, [2**32 - 1], [0.0], ("4294967295",)),
        ("Get", REAL, [2], [0.0], ("offset", "Integer")),
        ("Get", INTEGER, [5], [0], ("y", "Real")),
        ("Set", BOOLEAN, [2], [0], ("offset", "Integer")),
        ("Get", STRING, [0], [b""], ("time_constant", "Real")),
        ("Set", STRING, [3], [b"1"], ("u", "Real")),
        ("Set", REAL, [0], [2e-3], ("time_constant", "fixed parameter")),
        ("Set", REAL, [5], [1.0], ("y", "continuous output")),
    ],
)
def test_a_wrong_reference_is_refused_with_the_reason(library, way, kind, references, values, facts):
    names = ("Real", "Integer", "Boolean", "String")
    name = library.function(names[kind])[4:]
    with library.instantiate().begin() as fmu:
        assert fmu.transfer(way, name, references, values) == ERROR
        check_refusal(fmu, library.function(way + names[kind]), *facts)


@pytest.mark.parametrize(
    ("function", "arguments", "facts"),
    [
        ("SetFMUstate", lambda f: [None], ("state", "NULL")),
        ("GetFMUstate", lambda f: [None], ("state", "NULL")),
        ("SerializedFMUstateSize", lambda f: [None, byref(c_size_t())], ("state", "NULL")),
        ("SerializedFMUstateSize", lambda f: [f.save(), None], ("size", "NULL")),
        ("SerializeFMUstate", lambda f: [None, byref(c_double()), c_size_t(8)], ("state", "NULL")),
        ("SerializeFMUstate", lambda f: [f.save(), None, c_size_t(10_000)], ("bytes", "NULL")),
        ("DeSerializeFMUstate", lambda f: [None, c_size_t(8), byref(c_void_p())], ("bytes", "NULL")),
        ("DeSerializeFMUstate", lambda f: [byref(c_double()), c_size_t(8), None], ("state", "NULL")),
        ("DoStep", None, ("time", "nan s", "finite")),
    ],
)
def test_a_wrong_argument_is_refused_with_the_reason(library, function, arguments, facts):
    with library.instantiate().begin() as fmu:
        assert (fmu.call(function, *arguments(fmu)) if arguments else fmu.step(math.nan)) == ERROR
        check_refusal(fmu, library.function(function), *facts)


def check_refusal(fmu, *facts):
    """Check a refusal for good, which was the first."""
    assert fmu.log[0][:2] == (ERROR, "logStatusError"), fmu.log
    assert_names(fmu.log[0][2], *facts)
    assert fmu.get("fault_code", "time_constant") == [998, 1e-3]
    assert fmu.step(0) == ERROR
    assert_names(fmu.log[1][2], "earlier fault", fmu.log[0][2])
    if fmu.library.version == 2:
        assert fmu.reason() == fmu.log[0][2]
    assert (fmu.call("Reset"), fmu.begin().step(0)) == (OK, OK)


def test_a_wrong_reference_among_right_ones_sets_no_value(library):
    with library.instantiate().begin(u=1.0) as fmu:
        u, kind, _ = library.variables["u"]
        assert fmu.transfer("Set", kind, [u, 999], [3.0, 3.0]) == ERROR
        assert fmu.get("u") == [1.0]


@pytest.mark.parametrize("names", [["y", "level"], ["level", "y"], [], ["y", "level", "u"] * 10])
def test_reals_are_read_and_set_in_any_order_and_number(library, names):
    """Lists of neighbours, of others, empty ones and those longer than there are variables, each twice."""
    with library.instantiate().begin(u=2.0) as fmu:
        fmu.step(0)
        (u, kind, _), expected = library.variables["u"], fmu.get(*names)
        for _ in range(2):
            values = [0.0] * len(names)
            assert fmu.transfer("Get", kind, [library.variables[name][0] for name in names], values) == OK
            assert values == expected
        for last in (1.0, 2.5):
            assert fmu.transfer("Set", kind, [u] * 30, [0.0] * 29 + [last]) == OK
            assert fmu.get("u") == [last]


def test_a_wrong_status_query_is_discarded(library2):
    right = {"GetRealStatus": (2, c_double()), "GetBooleanStatus": (3, c_int()), "GetStringStatus": (1, c_char_p())}
    with library2.instantiate().begin() as fmu:
        for function, (kind, room) in right.items():
            assert fmu.call(function, kind, byref(room)) == OK
            assert fmu.call(function, kind + 1, byref(room)) == DISCARD
            assert fmu.call(function, kind, None) == DISCARD


def test_unsupported_optional_functions_are_refused_without_harm(library2):
    with library2.instantiate().begin() as fmu:
        reference, value = byref(c_uint(0)), byref(c_double())
        assert fmu.call("SetRealInputDerivatives", reference, c_size_t(1), byref(c_int(1)), value) == ERROR
        assert fmu.call("GetRealOutputDerivatives", reference, c_size_t(1), byref(c_int(1)), value) == ERROR
        assert fmu.call("CancelStep") == ERROR
        for function in ("GetStatus", "GetRealStatus", "GetIntegerStatus", "GetBooleanStatus", "GetStringStatus"):
            assert fmu.call(function, 0, byref(c_double())) == DISCARD
        assert len(fmu.log) == 8
        assert fmu.step(0) == OK
