"""Saving, restoring and serialising the state of a native FMU."""

import struct
import zlib
from ctypes import byref, c_int, c_size_t, c_uint, create_string_buffer

import pytest


@pytest.fixture(scope="module")
def library(unpacked, lag):
    from raw import Library

    return Library(unpacked(lag))


def run(fmu):
    return [(fmu.set(u=n / 2.0), fmu.step(n), *fmu.get("y", "level", "steps")) for n in range(3, 8)]


def test_a_saved_state_continues_as_the_first_run_did_in_any_instance(library):
    from raw import OK

    with library.instantiate() as fmu, library.instantiate() as other:
        fmu.begin(u=1.0, gain=3.0)
        for n in range(3):
            fmu.step(n)
        saved = fmu.save()
        text = fmu.serialise(saved)
        first = run(fmu)
        fmu.call("SetFMUstate", saved)
        assert run(fmu) == first
        status, restored = other.deserialise(text)
        assert (status, other.call("SetFMUstate", restored)) == (OK, OK)
        assert other.last_time() == 3 * 250e-6
        assert run(other) == first
        assert other.serialise(restored) == text


def test_a_state_is_saved_into_the_memory_of_an_earlier_one(library):
    with library.instantiate() as fmu:
        fmu.begin(u=1.0)
        saved = fmu.save()
        address = saved.value
        fmu.step(0)
        after = fmu.get("y")
        fmu.save(saved)
        fmu.step(1)
        assert saved.value == address
        fmu.call("SetFMUstate", saved)
        assert fmu.get("y") == after


@pytest.mark.parametrize("wrong", [{"u": 5.0}, {"y": 1.0}], ids=["failed step", "wrong call"])
def test_a_saved_state_brings_back_a_run_from_before_its_fault(library, wrong):
    from raw import OK

    with library.instantiate() as fmu:
        fmu.begin()
        saved = fmu.save()
        fmu.set(**wrong)
        assert fmu.step(0) != OK
        assert fmu.get("fault_code") != [0]
        assert fmu.call("SetFMUstate", saved) == OK
        assert (fmu.set(u=4.0), fmu.step(0), fmu.get("fault_code")) == (OK, OK, [0])


def test_a_fault_is_part_of_the_state(library):
    from raw import ERROR

    with library.instantiate() as fmu, library.instantiate() as other:
        fmu.begin()
        fmu.set(u=5.0)
        fmu.step(0)
        other.begin()
        other.call("SetFMUstate", other.deserialise(fmu.serialise(fmu.save()))[1])
        assert (other.step(0), other.get("fault_code")) == (ERROR, [1])
        assert "stopped by an earlier fault: u = 5 V" in other.log[-1][2]


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (lambda text: b"", "belongs to another FMU"),
        (lambda text: b"rubbish" * 100, "belongs to another FMU"),
        (lambda text: b"{x" + text[2:], "belongs to another FMU"),
        (lambda text: text[:-1], "the bytes are not whole"),
        (lambda text: text + b"\0", "the bytes are not whole"),
        (lambda text: text[:60] + bytes([text[60] ^ 1]) + text[61:], "the bytes are not whole"),
    ],
    ids=["nothing", "rubbish", "another guid", "short", "long", "one bit"],
)
def test_bytes_that_are_no_state_of_this_fmu_are_refused(library, spoil, sentence):
    from raw import ERROR

    with library.instantiate() as fmu:
        fmu.begin()
        status, state = fmu.deserialise(spoil(fmu.serialise(fmu.save())))
        assert (status, state.value) == (ERROR, None)
        assert sentence in fmu.log[0][2]


def test_a_state_with_an_integer_beyond_its_type_is_restored_and_the_integer_refused(library):
    """A count that a run of days might reach, were it not for 32 bits."""
    from raw import ERROR, OK

    with library.instantiate() as fmu:
        fmu.begin()
        assert [fmu.step(n) for n in range(7)] == [OK] * 7
        for count in (2.0**31, -(2.0**31) - 1.0):
            text = fmu.serialise(fmu.save())[:-4].replace(struct.pack("<d", 7.0), struct.pack("<d", count))
            status, state = fmu.deserialise(text + struct.pack("<I", zlib.crc32(text)))
            assert (status, fmu.call("SetFMUstate", state)) == (OK, OK)
            reference, value = c_uint(fmu.library.variables["steps"][0]), c_int()
            assert fmu.call("GetInteger", byref(reference), c_size_t(1), byref(value)) == ERROR
            assert fmu.log[-1][2] == f"fmi2GetInteger: steps = {count:g} does not fit into an integer"
            fmu.call("Reset")
            fmu.begin()
            assert [fmu.step(n) for n in range(7)] == [OK] * 7


def test_too_little_room_for_the_bytes_is_refused(library):
    from raw import ERROR

    with library.instantiate() as fmu:
        saved = fmu.save()
        room = create_string_buffer(10)
        assert fmu.call("SerializeFMUstate", saved, room, c_size_t(10)) == ERROR
        assert fmu.log[0][2].endswith("bytes, not 10")
