"""One response as different instruments write it: read as the same curve, or refused with the cause.

The names of the ways are those of the table in `docs/how-to/measured.md`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.measured.convention import contradictions
from amb_analysis.measured.files import read_measured
from tests.support.matlab_files import write_mat73
from tests.support.messages import assert_names, raises_naming

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "measured.md"
G = 9.80665  # m/s2
RATE = 2048.0
F = np.arange(4.0, 400.0, 1.0)
NAME = "fan.x/fan.f_x"


def exact(f):
    s = 2j * np.pi * f
    return 1.0 / (3.0 * s**2 + 40.0 * s + 3.0 * (2 * np.pi * 142.0) ** 2)  # m/N


H = exact(F)


def table(path, heads, *columns, frequency="frequency [Hz]", f=F, before=""):
    heads = ",".join([frequency, *(f"{NAME} {head}" for head in heads)])
    rows = "\n".join(",".join(f"{number:.12g}" for number in row) for row in np.column_stack([f, *columns]))
    path.write_text(f"{before}{heads}\n{rows}\n")
    return path


def universal(path, data, label="", x=F, abscissa="Hz", length=None):
    pyuff = pytest.importorskip("pyuff")
    function = {"type": 58, "func_type": 4, "rsp_node": 1, "rsp_dir": 1, "ref_node": 2, "ref_dir": 1, "id1": "NONE"}
    function |= {"abscissa_spacing": 0, "x": x, "data": data, "binary": 0, "abscissa_spec_data_type": 18}
    function |= {"ordinate_spec_data_type": 8, "orddenom_spec_data_type": 13, "abscissa_axis_units_lab": abscissa}
    function |= {"ordinate_axis_units_lab": label, "orddenom_axis_units_lab": "N" if label else ""}
    scale = {
        "length": length,
        "force": 1.0,
        "temp": 1.0,
        "temp_offset": 273.15,
        "units_description": "mm",
        "temp_mode": 1,
    }
    sets = [] if length is None else [{"type": 164, "units_code": 9} | scale]
    pyuff.UFF(str(path)).write_sets([*sets, function], "overwrite")
    return path


def record(path, times, form="%.12g"):
    """A record whose samples answer to the force by H."""
    n = len(times)
    f = np.fft.rfftfreq(n, 1 / RATE)
    U = np.fft.rfft(np.random.default_rng(1).standard_normal(n)) * (f > 0.0)
    columns = [np.fft.irfft(U, n), np.fft.irfft(U * exact(f), n)]
    rows = np.column_stack([times, *columns])
    np.savetxt(
        path, rows, delimiter=",", header="time [s],fan.f_x [N],fan.x [m]", comments="", fmt=[form, "%.9e", "%.9e"]
    )
    return path


def polar(values, scale=1.0):
    return scale * np.abs(values), np.degrees(np.angle(values))


def matlab(path):
    names = {"outputs": "fan.x", "inputs": "fan.f_x", "output_units": "m", "input_units": "N"}
    return write_mat73(path, {"frequencies": F[:, None], "response": H[:, None, None], **names})


LEVEL = 20 * np.log10(np.abs(H))
TIMES = np.arange(int(16 * RATE)) / RATE

READ: dict[str, Callable[[Path], Path]] = {
    "mm and kN": lambda d: table(d / "a.csv", ["amplitude [mm/kN]", "phase [deg]"], *polar(H, 1e6)),
    "dB and degrees": lambda d: table(d / "a.csv", ["amplitude [dB re 1 m/N]", "phase [deg]"], LEVEL, polar(H)[1]),
    "coherence in percent": lambda d: table(
        d / "a.csv", ["real [m/N]", "imag [m/N]", "coherence [%]"], H.real, H.imag, np.full(len(F), 90.0)
    ),
    "frequencies in kHz": lambda d: table(
        d / "a.csv", ["real [m/N]", "imag [m/N]"], H.real, H.imag, frequency="frequency [kHz]", f=F / 1e3
    ),
    "a line at 0 Hz": lambda d: table(
        d / "a.csv",
        ["real [m/N]", "imag [m/N]"],
        np.append(0.0, H.real),
        np.append(0.0, H.imag),
        f=np.append(0.0, F),
    ),
    "comments and capitals": lambda d: table(
        d / "a.csv", ["REAL (m/N)", "IMAG (m/N)"], H.real, H.imag, frequency="Frequency (Hz)", before="# a tester\n"
    ),
    "Matlab 7.3": lambda d: matlab(d / "a.mat"),
    "universal file in mm": lambda d: universal(d / "a.uff", 1e3 * H, length=1e3),
}
REFUSED = {
    "dB without a reference": (
        lambda d: table(d / "a.csv", ["amplitude [dB]", "phase [deg]"], LEVEL, polar(H)[1]),
        ("dB", "reference", "channel_units"),
    ),
    "phase without a unit": (
        lambda d: table(d / "a.csv", ["amplitude [m/N]", "phase"], *polar(H)),
        ("phase has no unit", "channel_units"),
    ),
    "dB that are called m/N": (
        lambda d: table(d / "a.csv", ["amplitude [m/N]", "phase [deg]"], LEVEL, polar(H)[1]),
        ("amplitude -", ">= 0", "dB re 1 m/N"),
    ),
    "degrees that are called radians": (
        lambda d: table(d / "a.csv", ["amplitude [m/N]", "phase [rad]"], *polar(H)),
        ("phase", "jumps", "channel_units", "deg"),
    ),
    "a missing sample": (
        lambda d: record(d / "t.csv", np.delete(TIMES, 999), "%.6f"),
        ("not evenly spaced", "resample"),
    ),
    "label against set 164": (
        lambda d: universal(d / "a.uff", H, "m", length=1e3),
        ("'m'", "set 164", "channel_units"),
    ),
}


@pytest.mark.parametrize("way", READ)
def test_the_same_response_is_read_from_each_way_of_writing_it(tmp_path, way):
    (curve,) = read_measured(READ[way](tmp_path)).responses
    np.testing.assert_allclose(curve.frequencies, F, rtol=1e-9)
    np.testing.assert_allclose(curve.values, H, rtol=1e-9)
    assert curve.unit == "m/N"
    if way == "coherence in percent":
        np.testing.assert_allclose(curve.coherence, 0.9)


def test_an_acceleration_in_g_is_that_of_the_displacement(tmp_path):
    s = 2j * np.pi * F
    path = table(tmp_path / "a.csv", ["amplitude [g/N]", "phase [deg]"], *polar(s**2 * H, 1 / G))
    (curve,) = read_measured(path).responses
    assert curve.unit == "(m/s2)/N"
    np.testing.assert_allclose(curve.values, s**2 * H, rtol=1e-9)


def test_rounded_times_give_the_response_of_exact_times(tmp_path):
    exactly, rounded = (
        read_measured(record(tmp_path / f"{form[1:]}.csv", TIMES, form), inputs=["fan.f_x"]).responses[0]
        for form in ("%.17g", "%.6f")
    )
    np.testing.assert_allclose(rounded.frequencies, exactly.frequencies, rtol=1e-7)
    np.testing.assert_allclose(rounded.values, exactly.values, rtol=1e-9)
    within = (exactly.frequencies > 20.0) & (exactly.frequencies < 100.0)
    np.testing.assert_allclose(rounded.values[within], exact(rounded.frequencies[within]), rtol=0.05)


@pytest.mark.parametrize("way", REFUSED)
def test_a_way_of_writing_that_has_two_meanings_is_refused_with_its_cause(tmp_path, way):
    write, facts = REFUSED[way]
    with raises_naming(ValueError, *facts):
        read_measured(write(tmp_path), inputs=["fan.f_x"] if way == "a missing sample" else [])


SIGNS = {
    "exp(-j omega t)": (H.conj(), "exp(-j omega t)"),
    "reversed force": (-H, "180 degrees"),
    "amplitudes without phases": (np.abs(H) + 0j, "no phase"),
}


@pytest.mark.parametrize("way", SIGNS)
def test_another_sign_is_named(tmp_path, way):
    changed, fact = SIGNS[way]
    path = table(tmp_path / "a.csv", ["real [m/N]", "imag [m/N]"], changed.real, changed.imag)
    (sentence,) = contradictions(read_measured(path).responses, [H])
    assert_names(sentence, NAME, fact)


def test_the_page_lists_the_ways_that_are_tested():
    section = PAGE.read_text().partition("## As instruments write it")[2].partition("\n## ")[0]
    listed = set(re.findall(r"^\| (.+?) \|", section, re.MULTILINE)) - {"written as", "---"}
    assert listed == {*READ, *REFUSED, *SIGNS, "acceleration in g", "rounded times"}
