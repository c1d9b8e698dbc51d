"""Saving, restoring and serialising the state of an FMU of either flavour and version."""

import re
import struct
import zlib
from ctypes import byref, c_size_t, c_void_p, cast, create_string_buffer

import pytest
from raw import ERROR, OK

from tests.support.messages import assert_names


def run(fmu):
    return [(fmu.set(u=n / 2.0), fmu.step(n), *fmu.get("y", "level", "steps")) for n in range(3, 8)]


def test_a_saved_state_continues_the_run_in_any_instance(library):
    with library.instantiate() as fmu, library.instantiate() as other:
        fmu.begin(u=1.0, gain=3.0)
        for n in range(3):
            fmu.step(n)
        saved = fmu.save()
        text = fmu.serialise(saved)
        first = run(fmu)
        fmu.restore(saved)
        assert run(fmu) == first
        status, restored = other.deserialise(text)
        assert (status, other.restore(restored)) == (OK, OK)
        assert other.last_time() == 3 * 250e-6
        assert run(other) == first
        assert other.serialise(restored) == text


def test_saving_reuses_the_memory_of_an_earlier_state(library):
    with library.instantiate().begin(u=1.0) as fmu:
        saved = fmu.save()
        address = saved.value
        fmu.step(0)
        after = fmu.get("y")
        fmu.save(saved)
        fmu.step(1)
        assert saved.value == address
        fmu.restore(saved)
        assert fmu.get("y") == after


def test_a_fault_is_part_of_the_state(library):
    with library.instantiate() as fmu, library.instantiate() as other:
        fmu.begin()
        fmu.set(u=5.0)
        fmu.step(0)
        other.begin()
        other.restore(other.deserialise(fmu.serialise(fmu.save()))[1])
        assert (other.step(0), other.get("fault_code")) == (ERROR, [1])
        assert_names(other.log[-1][2], "earlier fault", "u = 5 V")


@pytest.mark.parametrize(
    ("spoil", "facts"),
    [
        (lambda text: b"", ("another FMU",)),
        (lambda text: b"rubbish" * 100, ("another FMU",)),
        (lambda text: b"{x" + text[2:], ("another FMU",)),
        (lambda text: text[:-1], ("damaged",)),
        (lambda text: text + b"\0", ("damaged",)),
        (lambda text: text[:60] + bytes([text[60] ^ 1]) + text[61:], ("damaged",)),
    ],
    ids=["nothing", "rubbish", "another guid", "short", "long", "one bit"],
)
def test_bytes_that_are_no_state_of_this_fmu_are_refused(library, spoil, facts):
    with library.instantiate().begin() as fmu:
        status, state = fmu.deserialise(spoil(fmu.serialise(fmu.save())))
        assert (status, state.value) == (ERROR, None)
        assert_names(fmu.log[0][2], *facts)


def test_an_integer_beyond_its_type_in_a_state_is_refused(library):
    """A count that a run of days might reach, were it not for 32 bits."""
    with library.instantiate().begin() as fmu:
        assert [fmu.step(n) for n in range(7)] == [OK] * 7
        for count in (2.0**31, -(2.0**31) - 1.0):
            text = fmu.serialise(fmu.save())[:-4].replace(struct.pack("<d", 7.0), struct.pack("<d", count))
            status, state = fmu.deserialise(text + struct.pack("<I", zlib.crc32(text)))
            assert (status, fmu.restore(state)) == (OK, OK)
            reference, kind, _ = library.variables["steps"]
            assert fmu.transfer("Get", kind, [reference], [0]) == ERROR
            function = library.function("GetInteger")
            assert_names(fmu.log[-1][2], f"{function}", "steps", f"{count:g}", "integer")
            fmu.call("Reset")
            fmu.begin()
            assert [fmu.step(n) for n in range(7)] == [OK] * 7


NO_STATE = ("pointer", "no state")


@pytest.mark.parametrize("call", ["SetFMUstate", "SerializedFMUstateSize", "SerializeFMUstate"])
def test_a_pointer_to_no_state_is_not_dereferenced(library, call):
    """Address 8 cannot be read; a state that was freed, a copy of one, and another instance's are none either."""
    with library.instantiate() as fmu, library.instantiate() as other:
        saved, before = fmu.begin(u=1.0).save(), fmu.save()
        copy, freed = create_string_buffer(fmu.serialise(saved)), c_void_p(saved.value)
        assert fmu.call("FreeFMUstate", byref(saved)) == OK
        for wrong in (c_void_p(8), cast(copy, c_void_p), freed, other.begin().save()):
            rest = (byref(c_size_t()),) if "Size" in call else (copy, c_size_t(len(copy))) if "ize" in call else ()
            assert fmu.call(call, wrong, *rest) == ERROR
            assert_names(fmu.log[-1][2], library.function(call), *NO_STATE)
            assert fmu.restore(before) == OK, "the instance lives on from a state of its own"
        assert fmu.step(0) == OK


def test_a_pointer_to_no_state_is_not_freed(library):
    with library.instantiate() as fmu, library.instantiate() as other:
        saved = fmu.begin(u=1.0).save()
        copied, foreign = c_void_p(saved.value), other.begin().save()
        assert fmu.call("FreeFMUstate", byref(saved)) == OK
        for wrong in (copied, foreign, c_void_p(8)):
            value = wrong.value
            assert (fmu.call("FreeFMUstate", byref(wrong)), wrong.value) == (ERROR, value)
            assert_names(fmu.log[-1][2], library.function("FreeFMUstate"), *NO_STATE)
        assert (fmu.step(0), other.restore(foreign), other.step(0)) == (OK, OK, OK)


def test_a_state_is_allocated_if_the_host_left_its_pointer_unset(library):
    with library.instantiate() as fmu:
        unset = c_void_p(8)
        saved = fmu.begin(u=1.0).save(unset)
        assert saved.value != 8
        assert (fmu.step(0), fmu.restore(saved), fmu.last_time()) == (OK, OK, 0.0)


def test_any_number_of_states_coexists(library):
    with library.instantiate().begin(u=1.0) as fmu:
        saved, outputs = [], []
        for n in range(40):
            fmu.step(n)
            saved.append(fmu.save())
            outputs.append(fmu.get("y"))
        for n in (3, 20, 11):
            fmu.call("FreeFMUstate", byref(saved[n]))
        for n in sorted({*range(40)} - {3, 11, 20}, reverse=True):
            assert fmu.restore(saved[n]) == OK
            assert (fmu.get("y"), fmu.last_time()) == (outputs[n], n * 250e-6 + 250e-6)
        assert len(set(map(tuple, outputs))) == 40


def test_too_small_a_buffer_for_the_bytes_is_refused(library):
    with library.instantiate() as fmu:
        room = create_string_buffer(10)
        assert fmu.call("SerializeFMUstate", fmu.save(), room, c_size_t(10)) == ERROR
        function = library.function("SerializeFMUstate")
        assert re.fullmatch(rf"{function}: size = 10 bytes .* >= \d+ bytes.*", fmu.log[0][2])


def test_a_freed_state_is_null_and_null_may_be_freed(library):
    with library.instantiate() as fmu:
        saved = fmu.save()
        for state in (byref(saved), byref(saved), byref(c_void_p()), None):
            assert fmu.call("FreeFMUstate", state) == OK
            assert (saved.value, fmu.log) == (None, [])
