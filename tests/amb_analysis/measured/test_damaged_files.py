"""Measured data whose content contradicts what the file announces are refused; nothing hangs or ends in a traceback."""

from __future__ import annotations

import random
from contextlib import suppress

import numpy as np
import pytest

from amb_analysis.measured.files import read_measured
from amb_analysis.measured.records import Modes
from amb_analysis.studies.rotor_fit import mode_residuals
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

pyuff = pytest.importorskip("pyuff")

N = 100
F = np.linspace(2.0, 1000.0, N)
H = 1.0 / (1.0 - (F / 42.0) ** 2 + 0.02j * F / 42.0)
SET = {
    **{"type": 58, "func_type": 4, "rsp_node": 1, "rsp_dir": 1, "ref_node": 2, "ref_dir": 1, "id1": "NONE"},
    **{"abscissa_spacing": 1, "ordinate_axis_units_lab": "m", "orddenom_axis_units_lab": "N"},
    **{"ordinate_spec_data_type": 8, "orddenom_spec_data_type": 13, "x": F, "data": H},
}
MODE = """    -1
    55
a
b
c
d
e
         1         3         3         8         2         6
         2         4         0         1
{eigenvalue}            1            0            1            0
         1
  0.00000e+00  1.00000e+00  2.00000e+00  3.00000e+00  4.00000e+00  5.00000e+00
    -1
"""


@pytest.fixture
def uff(tmp_path):
    """`uff(binary, change)`: the path of a file of a response whose bytes a function has changed."""

    def write(binary, change=lambda content: content, **values):
        path = tmp_path / "a.uff"
        path.unlink(missing_ok=True)  # pyuff writes binary sets at the end of a file alone
        pyuff.UFF(str(path)).write_sets([SET | {"binary": binary} | values], "add")
        path.write_bytes(change(path.read_bytes()))
        return path

    return write


def head_and_data(content):
    """The first 13 lines of a file of one set, and the rest."""
    lines = content.splitlines(keepends=True)
    return b"".join(lines[:13]), b"".join(lines[13:])


def first_line_of_data(content):
    head, data = head_and_data(content)
    return head + data.splitlines(keepends=True)[0] + b"    -1\n"


def half_of_the_bytes(content):
    head, data = head_and_data(content)
    return head + data[: 8 * N] + b"\n    -1\n"


def all_but_a_number(content):
    head, data = head_and_data(content)
    return head + data[: 8 * (2 * N - 1)] + b"\n    -1\n"


@pytest.mark.parametrize(
    ("binary", "change", "n"), [(0, first_line_of_data, 2), (1, half_of_the_bytes, 50), (1, all_but_a_number, 99)]
)
def test_a_response_has_the_points_that_it_announces(uff, binary, change, n):
    assert len(read_measured(uff(binary)).responses[0].values) == N
    with raises_naming(ValueError, "a.uff", "100 points", str(n)):
        read_measured(uff(binary, change))


def with_field(number, value):
    """The content with another value in a field of six characters of the first line of a binary set."""

    def change(content):
        at = content.index(b"58b") + 3 + 6 * number
        return content[:at] + b"%6d" % value + content[at + 6 :]

    return change


@pytest.mark.parametrize(("number", "value"), [(0, 2), (0, 7), (1, 1), (1, 3)])
def test_numbers_of_another_byte_order_or_format_are_refused(uff, number, value):
    """Field 0 is the byte order, here wrong (2) and unknown (7); field 1 the format: VAX (1), IBM (3)."""
    with raises_naming(ValueError, "a.uff"):
        read_measured(uff(1, with_field(number, value)))


def test_numbers_of_the_byte_order_that_a_file_states_are_read(uff):
    def swapped(content):
        head, data = head_and_data(with_field(0, 2)(content))
        numbers = np.frombuffer(data[: 16 * N], "<f8").astype(">f8").tobytes()
        return head + numbers + data[16 * N :]

    (curve,) = read_measured(uff(1, swapped)).responses
    np.testing.assert_array_equal(curve.values, H)


@pytest.mark.parametrize("value", [7.0, -0.5])
def test_a_coherence_beyond_its_range_is_refused(tmp_path, uff, value):
    sets = [SET | {"binary": 0}, SET | {"binary": 0, "func_type": 6, "data": np.full(N, value)}]
    pyuff.UFF(str(tmp_path / "b.uff")).write_sets(sets, "overwrite")
    rows = np.column_stack([F, H.real, H.imag, np.full(N, value)])
    head = "frequency [Hz],y/u real [m/N],y/u imag [m/N],y/u coherence"
    np.savetxt(tmp_path / "b.csv", rows, delimiter=",", header=head, comments="")
    ends = {"inputs": ["u"], "outputs": ["y"], "input_units": ["N"], "output_units": ["m"]}
    np.savez(tmp_path / "b.npz", frequencies=F, response=H, coherence=rows[:, 3], **ends)
    for name in ("b.uff", "b.csv", "b.npz"):
        with raises_naming(ValueError, name, "coherence", f"{value:g}", "0 to 1"):
            read_measured(tmp_path / name)


def test_a_coherence_rounded_above_1_is_1(tmp_path):
    rows = np.column_stack([F, H.real, H.imag, np.full(N, 1.0 + 1e-7)])
    head = "frequency [Hz],y/u real [m/N],y/u imag [m/N],y/u coherence"
    np.savetxt(tmp_path / "b.csv", rows, delimiter=",", header=head, comments="")
    assert read_measured(tmp_path / "b.csv").responses[0].coherence.max() == 1.0


@pytest.mark.parametrize("eigenvalue", ["          0.0          0.0", "          nan          nan"])
def test_a_mode_without_an_eigenvalue_is_refused(tmp_path, eigenvalue):
    (tmp_path / "m.uff").write_text(MODE.format(eigenvalue=eigenvalue))
    with raises_naming(ValueError, "m.uff", "eigenvalue"):
        read_measured(tmp_path / "m.uff")


@pytest.mark.parametrize("binary", [0, 1])
def test_damaged_universal_files_are_read_or_refused(uff, binary):
    chance = random.Random(1)

    def damaged(content):
        changed = bytearray(content)
        for _ in range(3):
            changed[chance.randrange(1000)] = chance.choice(b" 0159-bx\n\xff")
        return bytes(changed[: chance.randrange(200, 2 * len(content))])

    for _ in range(40):
        with suppress(ValueError):
            read_measured(uff(binary, damaged))


@pytest.mark.parametrize("units", [[], ["m", "m"]])
def test_a_channel_has_one_unit(tmp_path, units):
    record = {"time": np.arange(8.0), "y": np.ones(8), "units.y": np.array(units, dtype="U1")}
    np.savez(tmp_path / "r.npz", **record)
    with raises_naming(ValueError, "r.npz", "units.y", str(len(units))):
        read_measured(tmp_path / "r.npz", inputs=["y"])


def test_modes_above_all_of_the_rotor_are_refused():
    """The nearest of no modes has no number, which the message said alone."""
    rotor = load_rotor("compressor")
    with raises_naming(ValueError, "compressor", "Hz"):
        mode_residuals(rotor, "free", 0.0, Modes(np.array([1e9]), np.array([0.01])))


def padded(content, end=b"\n", width=None):
    """The content with blanks at the ends of its lines of text, and another end of line."""
    binary = b"58b" in content
    head, data = head_and_data(content) if binary else (content, b"")
    lines = [line + b"   " if width is None else line.ljust(width) for line in head.splitlines()]
    numbers, mark, _ = data.partition(b"\n    -1") if binary else (b"", b"", b"")
    rest = end + (b"    -1" + b" " * 74 + end) if mark else b""
    return end.join(lines) + end + numbers + rest


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
@pytest.mark.parametrize("width", [None, 80, 120])
@pytest.mark.parametrize("order", ["binary first", "text first", "text alone"])
def test_padded_lines_are_read_beside_binary_numbers(tmp_path, uff, order, width, end):
    """Blanks after the last number of a text set were taken for a number, if any set of the file was binary."""
    text = padded(uff(0, **{"rsp_node": 5, "data": 2 * H[:-1], "x": F[:-1]}).read_bytes(), end, width)
    binary = padded(uff(1).read_bytes(), end, width)
    parts = {"binary first": [binary, text], "text first": [text, binary], "text alone": [text]}[order]
    (tmp_path / "p.uff").write_bytes(b"".join(parts))
    responses = {r.name: r for r in read_measured(tmp_path / "p.uff").responses}
    np.testing.assert_allclose(responses["5.x/2.x"].values, 2 * H[:-1], rtol=1e-11)
    if len(parts) == 2:
        np.testing.assert_array_equal(responses["1.x/2.x"].values, H)
