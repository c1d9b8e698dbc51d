"""The data of a native FMU: damaged, foreign and newer ones are refused; one engine runs several."""

import base64
import dataclasses
import random
import struct
import zlib

import numpy as np
import pytest

from fmi_export.building.native.data import HEADER, PIECE, SENTENCE, VARIABLE, VERSION, model_data
from fmi_export.building.native.engines import engine_key
from fmi_export.interface import Interface
from fmi_export.model import Instance
from tests.support.messages import assert_names, raises_naming


@pytest.fixture(scope="module")
def library(unpacked, lag):
    from raw import Library

    return Library(unpacked(lag))


@pytest.fixture(scope="module")
def content(unpacked, lag):
    return (unpacked(lag) / "resources" / "model.bin").read_bytes()


def instance_with(library, content, guid=None):
    """An instance with data in memory."""
    location = "data:;base64," + base64.b64encode(content).decode()
    return library.instantiate(guid=guid or library.guid, resources=location)


def refusal(library, content):
    fmu = instance_with(library, content)
    assert fmu.pointer is None
    (message,) = fmu.log
    return message[2]


def sealed(content):
    """The same with the right checksum."""
    return content[:-4] + struct.pack("<I", zlib.crc32(content[:-4]))


def sections(content):
    """Begin and end of each part of the data."""
    *_, n_parameters, n_inputs, n_outputs, _, _, n_constants, n_faults, n_warnings, n_pieces, n_text, _, _ = (
        HEADER.unpack_from(content)
    )
    n = n_parameters + n_inputs + n_outputs
    sizes = {
        "magic": 8,
        "version": 8,
        "key": 32,
        "guid": 48,
        "counts": 96,
        "constants": 8 * n_constants,
        "start": 8 * n,
        "minima": 8 * n,
        "maxima": 8 * n,
        "faults": SENTENCE.size * n_faults,
        "warnings": SENTENCE.size * n_warnings,
        "variables": VARIABLE.size * n,
        "pieces": PIECE.size * n_pieces,
        "types": n,
        "text": n_text,
        "checksum": 4,
    }
    ends = np.cumsum(list(sizes.values())).tolist()
    assert ends[-1] == len(content)
    return {name: (end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}


def test_a_flipped_bit_in_any_byte_is_noticed(library, content):
    for name, (begin, end) in sections(content).items():
        for at in range(begin, end):
            damaged = bytearray(content)
            damaged[at] ^= 1 << (at % 8)
            message = refusal(library, bytes(damaged))
            assert_names(message, "rebuild the FMU")
            if name not in ("magic", "version", "counts"):
                assert_names(message, "checksum")


def test_truncated_data_are_refused_at_any_length(library, content):
    for size in {0, 1, HEADER.size - 1, HEADER.size, HEADER.size + 1, *range(200, len(content), 97), len(content) - 1}:
        message = refusal(library, content[:size])
        assert_names(message, "no data" if size < HEADER.size else f"{size} bytes")
    assert_names(refusal(library, content + b"\0"), f"{len(content) + 1} bytes", f"{len(content)}")


def test_data_of_a_newer_format_are_refused_with_that_reason(library, content):
    newer = sealed(content[:8] + struct.pack("<Q", VERSION + 1) + content[16:])
    assert_names(refusal(library, newer), f"number {VERSION + 1}", f"number {VERSION}")


def test_data_for_another_engine_are_refused(library, content, lag):
    other = model_data(lag, np.zeros(1), library.guid, "f" * 32)
    key = engine_key([lag])
    assert_names(refusal(library, other), f"engine {'f' * 32}", f"engine {key}", "rebuild")


@pytest.mark.parametrize("wild", [2**28 + 1, 2**31, 2**61, 2**64 - 1])
@pytest.mark.parametrize("count", range(10))
def test_impossible_sizes_with_a_right_checksum_are_refused(library, content, count, wild):
    begin = sections(content)["counts"][0] + 8 * count
    message = refusal(library, sealed(content[:begin] + struct.pack("<Q", wild) + content[begin + 8 :]))
    assert_names(message, "damaged", "sizes")


@pytest.mark.parametrize(
    ("section", "offset", "wrong"),
    [
        ("faults", 8, b"\xff\xff\xff\xff"),
        ("faults", 12, b"\xff\xff\xff\xff"),
        ("warnings", 0, b"\xff\xff\xff\x7f"),
        ("warnings", 4, b"\xff\xff\xff\xff"),
        ("warnings", 8, b"\xff\xff\xff\xff"),
        ("variables", 0, b"\xff\xff\xff\x7f"),
        ("variables", 4, b"\xff\xff\xff\xff"),
        ("variables", 8, b"\xff\xff\xff\xff"),
        ("variables", 16, b"\xff\xff\xff\xff"),
        ("pieces", 0, b"\xff\xff\xff\xff"),
        ("pieces", 4, b"\xfd\xff\xff\xff"),
        ("pieces", 4, b"\xff\xff\xff\x7f"),
        ("types", 0, b"\x03"),
        ("text", -1, b"x"),
    ],
)
def test_dangling_references_with_a_right_checksum_are_refused(library, content, section, offset, wrong):
    begin, end = sections(content)[section]
    at = (end if offset < 0 else begin) + offset
    message = refusal(library, sealed(content[:at] + wrong + content[at + len(wrong) :]))
    assert_names(message, "damaged", "references")


def test_any_tables_with_a_right_checksum_are_survived(library, content):
    draw = random.Random(2006)
    begin, end = sections(content)["faults"][0], sections(content)["checksum"][0]
    lived = 0
    for _ in range(2000):
        wild = bytearray(content)
        for _ in range(draw.randint(1, 4)):
            wild[draw.randrange(begin, end)] = draw.randrange(128)
        with instance_with(library, sealed(bytes(wild))) as fmu:
            if fmu.pointer:
                lived += 1
                fmu.set(u=11.0)
                fmu.setup()
                fmu.call("EnterInitializationMode")
                fmu.call("ExitInitializationMode")
    assert lived > 100


def test_one_engine_runs_other_constants_and_another_interface(library, lag):
    """In one process, interleaved: kernels receive the data of their instance."""
    from raw import ERROR, OK

    names = {"u": "voltage", "y": "response"}

    def renamed(v):
        wider = {"maximum": 20.0} if v.name == "u" else {}
        return dataclasses.replace(
            v,
            name=names.get(v.name, v.name),
            depends_on=tuple(names.get(n, n) for n in v.depends_on),
            warning=v.warning.replace("{u}", "{voltage}"),
            **wider,
        )

    table = Interface(tuple(renamed(v) for v in lag.interface.variables))
    other = dataclasses.replace(lag, interface=table, n_state=7, n_work=300, faults={1: "voltage = {voltage} V"})
    assert engine_key([other]) == engine_key([lag])
    data = model_data(other, np.array([3.0, 1.0]), "{other}", engine_key([other]))
    cores = Instance(lag, np.zeros(1)), Instance(other, np.array([3.0, 1.0]))
    with library.instantiate() as ours, instance_with(library, data, "{other}") as theirs:
        for fmu, core in ((ours, cores[0]), (theirs, cores[1])):
            fmu.begin()
            core.initialise()
        for n in range(5):
            for fmu, core in ((ours, cores[0]), (theirs, cores[1])):
                core.inputs[0] = float(n)
                assert fmu.set(u=float(n)) == OK  # the same value reference
                assert fmu.step(n) == OK
                core.step(n * 250e-6, 250e-6)
                assert fmu.get("y", "level", "steps") == core.outputs[:3].tolist()
        assert cores[1].outputs[0] > cores[0].outputs[0]
        for fmu, message in (
            (ours, "u = 11 V is not allowed; it must be >= -10 and <= 10 V"),
            (theirs, "level = 22 V"),
        ):
            fmu.set(u=11.0)
            assert fmu.step(5) == ERROR
            assert message in fmu.log[-1][2]


def test_a_state_is_restored_only_by_instances_with_the_same_data(library, lag):
    from raw import ERROR, OK

    data = model_data(lag, np.ones(1), "{other}", engine_key([lag]))
    with library.instantiate() as ours, library.instantiate() as same, instance_with(library, data, "{other}") as other:
        text = ours.begin().serialise(ours.save())
        assert same.begin().deserialise(text)[0] == OK
        assert other.begin().deserialise(text)[0] == ERROR
        assert_names(other.log[0][2], "fmi2DeSerializeFMUstate", "another FMU")


@pytest.mark.parametrize(
    ("message", "facts"),
    [(3570 * "x" + "{u}", ("3584 bytes", "3605")), ("{v} is wrong", ("probe_lag", "'v'"))],
    ids=["longer than the buffer of the engine", "unknown variable"],
)
def test_a_message_that_an_engine_cannot_write_is_refused(lag, message, facts):
    with raises_naming(ValueError, *facts):
        model_data(dataclasses.replace(lag, faults={7: message}), np.zeros(1), "{}", "")
