"""What the slave writes to its log: by category, by instance, and errors always."""

from ctypes import c_size_t

import pytest
from raw import ERROR, OK

from fmi_export.log_categories import LOG_CATEGORIES
from tests.support.messages import assert_names


@pytest.mark.parametrize(
    ("category", "facts"),
    [
        (b"logNonsense", ("logNonsense", "logStatusWarning")),
        (None, ("NULL", "logStatusWarning")),
        ((), ("categories", "NULL")),
    ],
)
def test_a_wrong_log_category_is_refused_and_nothing_else_changes(library, category, facts):
    with library.instantiate() as fmu:

        def choose():
            return fmu.call("SetDebugLogging", 0, c_size_t(1), None) if category == () else fmu.debug(False, category)

        assert choose() == ERROR
        fmu.begin(u=1.0)
        assert choose() == ERROR
        assert [status for status, _, _ in fmu.log] == 2 * [ERROR]
        for _, _, text in fmu.log:
            assert_names(text, library.function("SetDebugLogging"), *facts)
        assert fmu.get("fault_code") == [0]
        if library.version == 2:
            assert (fmu.reason(), fmu.step(0), fmu.reason()) == (fmu.log[1][2], OK, "")
        fmu.set(u=5.0)
        assert fmu.step(1) == ERROR
        assert len(fmu.log) == 3, "it still logs"


@pytest.mark.parametrize(
    ("switched", "is_logged"),
    [
        ([(True, ())], (True, True)),
        ([(False, ())], (False, False)),
        ([(False, (b"logAll",))], (False, False)),
        ([(False, ()), (True, (b"logAll",))], (True, True)),
        ([(False, ()), (True, (b"logStatusWarning", b"logStatusFatal"))], (True, True)),
        ([(False, ()), (True, (b"logStatusDiscard", b"logStatusError"))], (False, False)),
        ([(False, ()), (True, (b"logStatusFatal",)), (True, (b"logStatusWarning",))], (True, True)),
        ([(False, (b"logStatusWarning",))], (False, False)),
        # of FMI 3.0 each call switches the categories that it names, of FMI 2.0 all
        ([(False, (b"logStatusError", b"logStatusFatal"))], (False, True)),
        ([(True, (b"logStatusWarning",)), (True, (b"logStatusFatal",))], (False, True)),
    ],
)
def test_warnings_are_logged_by_category_and_errors_always(library, switched, is_logged):
    with library.instantiate().begin() as fmu:
        assert [fmu.debug(on, *names) for on, names in switched] == [OK] * len(switched)
        fmu.set(u=4.0)
        fmu.step(0)
        fmu.set(u=5.0)
        fmu.step(1)
        warned = ["logStatusWarning"] * is_logged[library.version - 2]
        assert [category for _, category, _ in fmu.log] == [*warned, "logStatusError"]


def test_every_declared_category_can_be_chosen(library):
    with library.instantiate() as fmu:
        assert fmu.debug(True, *(name.encode() for name in LOG_CATEGORIES)) == OK


def test_without_logging_only_a_fault_is_in_the_log(library2):
    with library2.instantiate(logging=0).begin() as fmu:
        fmu.set(u=4.0)
        assert (fmu.step(0), fmu.log) == (OK, [])
        fmu.set(u=5.0)
        assert fmu.step(1) == ERROR
        assert [(status, category) for status, category, _ in fmu.log] == [(ERROR, "logStatusError")]
        assert fmu.reason() == "u = 5 V is 100 % too much (%s %n)", "a host can also request it"
        assert fmu.get("fault_code") == [1]
