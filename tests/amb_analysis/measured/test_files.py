"""The same measurement in files of every form, with units that are not SI."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from amb_analysis.measured.files import read_measured
from amb_analysis.measured.units import even_step
from tests.support.matlab_files import write_mat73
from tests.support.messages import raises_naming

F = np.arange(5.0, 100.0, 0.5)
S = 2j * np.pi * F
H = 1.0 / (3.0 * S**2 + 40.0 * S + 3.0 * (2 * np.pi * 42.0) ** 2)  # m/N
COHERENCE = np.linspace(0.8, 1.0, len(F))


def check(result, output="fan.x", source="fan.f_x", unit="m/N", values=H):
    (curve,) = result.responses
    assert (curve.output.name, curve.input.name, curve.unit) == (output, source, unit)
    np.testing.assert_allclose(curve.frequencies, F, rtol=1e-6)
    np.testing.assert_allclose(curve.values, values, rtol=1e-6)
    np.testing.assert_allclose(curve.coherence, COHERENCE, rtol=1e-6)


def test_reads_matlab_arrays(tmp_path):
    content = {
        "frequencies": F,
        "response": (S**2 * H / 9.80665).reshape(-1, 1, 1),
        "coherence": COHERENCE.reshape(-1, 1),
        "outputs": np.array(["acc1"], dtype=object),
        "inputs": np.array(["hammer"], dtype=object),
        "output_units": np.array(["g"], dtype=object),
        "input_units": np.array(["N"], dtype=object),
    }
    savemat(tmp_path / "a.mat", content)
    names = {"acc1": "fan.x", "hammer": "fan.f_x"}
    check(read_measured(tmp_path / "a.mat", names=names), unit="(m/s2)/N", values=S**2 * H)
    with raises_naming(ValueError, "'acc2'"):
        read_measured(tmp_path / "a.mat", names={"acc2": "fan.x"})


def uff_set(**values):
    base = {"type": 58, "rsp_node": 3, "rsp_dir": -1, "ref_node": 7, "ref_dir": 1, "abscissa_spacing": 1, "x": F}
    base |= {"id1": "NONE", "ordinate_axis_units_lab": "mm", "orddenom_axis_units_lab": "N", "binary": 0}
    return base | {"orddenom_spec_data_type": 13, "ordinate_spec_data_type": 8} | values


def test_universal_files_have_the_sign_of_their_directions(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    sets = [uff_set(func_type=4, data=-1e3 * H), uff_set(func_type=6, data=COHERENCE)]
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets(sets, "overwrite")
    check(read_measured(tmp_path / "a.uff"), output="3.x", source="7.x")


def test_universal_files_without_labels_are_in_si_units(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    labels = {"ordinate_axis_units_lab": "NONE", "orddenom_axis_units_lab": "NONE", "ordinate_spec_data_type": 12}
    pyuff.UFF(str(tmp_path / "a.unv")).write_sets([uff_set(func_type=4, data=H, **labels)], "overwrite")
    (curve,) = read_measured(tmp_path / "a.unv").responses
    assert curve.unit == "(m/s2)/N"
    np.testing.assert_allclose(curve.values, -H, rtol=1e-9)


def test_a_table_over_time_becomes_an_estimate(tmp_path):
    rng = np.random.default_rng(1)
    force = rng.standard_normal(4000)
    rows = np.column_stack([np.arange(4000) * 1e-3, force, 250.0 * force])
    np.savetxt(tmp_path / "t.csv", rows, delimiter=",", header='"time [s]","u [N]","y [mm]"', comments="")
    (curve,) = read_measured(tmp_path / "t.csv", inputs=["u"]).responses
    np.testing.assert_allclose(curve.values, 0.25, rtol=1e-6)
    with raises_naming(ValueError, "t.csv", "input"):
        read_measured(tmp_path / "t.csv")


@pytest.mark.parametrize("write", [savemat, write_mat73])
def test_a_matlab_record_has_the_units_of_its_structure_or_stated_ones(tmp_path, write):
    force, units = np.random.default_rng(1).standard_normal(4000), {"u": "kN", "y": "um"}
    record = {"time": np.arange(4000) * 1e-4, "u": force, "y": 5.0 * force}
    write(tmp_path / "t.mat", record | {"units": units})
    write(tmp_path / "bare.mat", record)
    for name, stated in (("t.mat", None), ("bare.mat", units)):
        (curve,) = read_measured(tmp_path / name, inputs=["u"], units=stated).responses
        np.testing.assert_allclose(curve.values, 5e-9, rtol=1e-6)
    with raises_naming(ValueError, "has no unit"):
        read_measured(tmp_path / "bare.mat", inputs=["u"])


@pytest.mark.parametrize("name", ["m.csv", "m.tsv", "m.txt"])
def test_reads_a_list_of_modes(tmp_path, name):
    (tmp_path / name).write_text("frequency [Hz];damping ratio [%]\n31,5;0,4\n140;\n")
    modes = read_measured(tmp_path / name).modes
    assert modes is not None
    np.testing.assert_allclose(modes.frequencies, [31.5, 140.0])
    np.testing.assert_allclose(modes.damping_ratios, [0.004, np.nan])


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("", ("headings",)),
        ("speed [Hz],y\n1,2\n", ("column", "'speed'")),
        ("frequency [Hz],y/u amplitude [m/N]\n1,2\n", ("amplitude", "phase")),
        ("frequency [Hz],y/u real [m],y/u imag [m]\n1,2,3\n2,2,3\n", ("output over input",)),
        ("frequency [Hz],y/u real [K/N],y/u imag [K/N]\n1,2,3\n2,2,3\n", ("unit", "'K'")),
        ("frequency [Hz],y/u real [m/N],y/u imag [m/N]\n2,2,3\n1,2,3\n", ("ascending",)),
        ("frequency [Hz],y/u real [m/N],y/u imag [m/N]\n1,2\n2,2,3\n", ("row 2", "3 values", "it has 2")),
        ("frequency [Hz],y/u real [m/N],y/u imag [m/N]\n1,a,3\n2,2,3\n", ("cell", "number")),
        ("frequency [Hz],y/u real [m/N],y/u imag [m/N]\n1,,3\n2,2,3\n", ("finite",)),
        ("time [s],u [N]\n0,1\n1,2\n3,4\n", ("evenly spaced",)),
        ("time [s],u [N]\n0,0,1,5\n0,5,2,5\n", ("row 2", "decimal commas", "semicolons")),
        ("frequency [Hz];damping ratio\n10,0;0.01\n", ("10,0", "0.01")),
    ],
)
def test_errors_name_the_faulty_part_of_a_table(tmp_path, text, facts):
    (tmp_path / "wrong.csv").write_text(text)
    with raises_naming(ValueError, str(tmp_path / "wrong.csv"), *facts):
        read_measured(tmp_path / "wrong.csv")


@pytest.mark.parametrize("name", ["a.mat", "a.npz", "a.uff", "a.nc", "a.xyz", "missing.csv"])
def test_files_that_are_no_measurement_are_refused(tmp_path, name):
    if not name.startswith("missing"):
        (tmp_path / name).write_bytes(b"no measurement")
    with raises_naming(ValueError, str(tmp_path / name)):
        read_measured(tmp_path / name)


RECORD = "time [s],fan.f_x [N],fan.x\n" + "".join(f"{k / 64},{k * k % 7},{k * k % 7}\n" for k in range(64))
CURVE = "frequency [Hz],y/u amplitude{},y/u phase{}\n10,1,-90\n20,2,-180\n"


@pytest.mark.parametrize(
    ("text", "name", "inputs"),
    [
        (RECORD, "fan.x", ["fan.f_x"]),
        (RECORD.replace("time [s]", "time"), "time", ["fan.f_x"]),
        (CURVE.format("", " [deg]"), "y/u amplitude", []),
        (CURVE.format(" [m/N]", ""), "y/u phase", []),
        (CURVE.format(" [m/N]", " [deg]").replace(" [Hz]", ""), "frequency", []),
    ],
)
def test_a_column_without_a_unit_is_refused(tmp_path, text, name, inputs):
    """A channel without a unit was taken to be in metres, and a phase in radians."""
    (tmp_path / "a.csv").write_text(text)
    with raises_naming(ValueError, f"{name} has no unit", "channel_units"):
        read_measured(tmp_path / "a.csv", inputs=inputs)


def test_a_stated_unit_replaces_that_of_the_file(tmp_path):
    (tmp_path / "a.csv").write_text(CURVE.format("", " [rad]").replace("[Hz]", "[kHz]"))
    stated = {"y/u amplitude": "(m/s2)/N", "y/u phase": "deg", "frequency": "Hz"}
    (curve,) = read_measured(tmp_path / "a.csv", units=stated).responses
    assert (curve.output.unit, list(curve.frequencies)) == ("m/s2", [10.0, 20.0])
    np.testing.assert_allclose(curve.values, [-1j, -2.0], atol=1e-12)
    with raises_naming(ValueError, "y/u phse", "y/u phase"):
        read_measured(tmp_path / "a.csv", units={**stated, "y/u phse": "deg"})


FORCED = "fan.x/fan.f_x"


def write_table(path, heads, columns, newline="\n", comment=""):
    rows = ["{}".format(",".join(f"{value:.12g}" for value in row)) for row in np.column_stack(columns)]
    path.write_text(newline.join([*([comment] if comment else []), heads, *rows]) + newline)
    return path


@pytest.mark.parametrize(
    ("heads", "comment"),
    [
        ("frequency [Hz],{} real [m/N],{} imag [m/N],{} coherence", "# exported by a tester"),
        ("frequency [Hz],{} real [m/N],{} imag [m/N],{} coherence", "% exported, by, a, tester"),
        ("# frequency [Hz],{} real [m/N],{} imag [m/N],{} coherence", "# written by numpy.savetxt"),
        ("Frequency [Hz],{} Real [m/N],{} Imag [m/N],{} Coherence", ""),
        ("FREQUENCY (Hz),{} REAL (m/N),{} IMAG (m/N),{} COHERENCE", ""),
        ("frequency (Hz),{} real ((m)/N),{} imaginary ((m)/N),{} coherence (1)", ""),
    ],
)
def test_comments_capitals_and_parentheses_are_read(tmp_path, heads, comment):
    columns = [F, H.real, H.imag, COHERENCE]
    check(read_measured(write_table(tmp_path / "a.csv", heads.format(*[FORCED] * 3), columns, comment=comment)))


def test_a_comment_between_rows_is_no_row(tmp_path):
    path = write_table(
        tmp_path / "a.csv", f"frequency [Hz],{FORCED} real [m/N],{FORCED} imag [m/N]", [F, H.real, H.imag]
    )
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:9], "# overload", *lines[9:]]))
    np.testing.assert_allclose(read_measured(path).responses[0].values, H, rtol=1e-9)


def test_a_first_line_that_is_no_heading_is_named(tmp_path):
    path = write_table(tmp_path / "a.csv", "frequency [Hz],y/u real [m/N]", [F, F])
    path.write_text("Exported by a tester\n" + path.read_text())
    with raises_naming(ValueError, "'Exported by a tester'", "headings"):
        read_measured(path)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        *((unit, 1.0) for unit in ("dB re 1 m/N", "dB re m/N", "dB (m/N)", "dB m/N", "dB ref. m/N")),
        ("dB re 1 (m/s2)/N", 1.0),
        ("dB re 1e-6 (m/s2)/N", 1e-6),
        ("dB re 1E-6(m/s2)/N", 1e-6),
        ("dB re 20 (mm/s2)/kN", 2e-5),
        ("dB re 1.0 um/s2/N", 1e-6),
    ],
)
def test_decibels_have_a_reference(tmp_path, unit, factor):
    heads = f"frequency [Hz],{FORCED} amplitude [{unit}],{FORCED} phase [deg],{FORCED} coherence [%]"
    columns = [F, 20 * np.log10(np.abs(H) / factor), np.degrees(np.angle(H)), 100 * COHERENCE]
    check(read_measured(write_table(tmp_path / "a.csv", heads, columns)), unit="(m/s2)/N" if "s2" in unit else "m/N")
    for wrong, facts in (("dB", f"{FORCED} amplitude,dB,reference"), ("dB re 0 m/N", "a.csv,reference 0,> 0")):
        with raises_naming(ValueError, *facts.split(",")):
            read_measured(write_table(tmp_path / "a.csv", heads.replace(unit, wrong), columns))


def test_a_line_at_0_hz_is_left_out_in_all_forms(tmp_path):
    f, h = np.append(0.0, F), np.append(np.nan, H)
    heads = f"frequency [Hz],{FORCED} real [m/N],{FORCED} imag [m/N]"
    names = {"outputs": ["fan.x"], "inputs": ["fan.f_x"], "output_units": ["m"], "input_units": ["N"]}
    content = {"frequencies": f.reshape(-1, 1), "response": h.reshape(-1, 1, 1)}
    cells = {key: np.array(value, dtype=object) for key, value in names.items()}
    savemat(tmp_path / "a.mat", content | cells)
    np.savez(tmp_path / "a.npz", **content, **names)
    paths = [write_table(tmp_path / "a.csv", heads, [f, h.real, h.imag]), tmp_path / "a.mat", tmp_path / "a.npz"]
    for path in paths:
        (curve,) = read_measured(path).responses
        np.testing.assert_allclose(curve.frequencies, F)
        np.testing.assert_allclose(curve.values, H, rtol=1e-9)


RATE = 2048.0
TIMES = {
    "six decimals": lambda t: np.round(t, 6),
    "cut to six decimals": lambda t: np.floor(t * 1e6) / 1e6,
    "six digits": lambda t: np.array([float(f"{value:.5e}") for value in t]),
    "single precision": lambda t: t.astype(np.float32).astype(float),
    "single precision as text": lambda t: np.array([float(f"{value:.9g}") for value in t.astype(np.float32)]),
    "since 1970": lambda t: t + 1.78e9,
    "from 100 s on, five decimals": lambda t: np.round(t + 100.0, 5),
}


@pytest.mark.parametrize("name", TIMES)
@pytest.mark.parametrize("rate", [1000.0, 1024.0, RATE, 4096.0])
def test_evenly_sampled_times_are_recognised_within_their_rounding(name, rate):
    """They were refused with the advice to resample, which would have been wrong."""
    assert even_step(TIMES[name](np.arange(8192) / rate)) == pytest.approx(1.0 / rate, rel=1e-7)


@pytest.mark.parametrize("rounded", ["six decimals", "six digits", "single precision"])
@pytest.mark.parametrize("missing", [1, 300, 4000, 8190])
def test_a_missing_sample_is_not_taken_for_rounding(rounded, missing):
    times = np.delete(TIMES[rounded](np.arange(8192) / RATE), missing)
    with raises_naming(ValueError, "not evenly spaced", "resample"):
        even_step(times)


@pytest.mark.parametrize(
    "times",
    [
        np.geomspace(1e-3, 1.0, 100),
        np.arange(100.0) * (1.0 + 1e-4 * np.arange(100.0)),
        np.arange(4000) / RATE + 1e-2 / RATE * np.random.default_rng(0).standard_normal(4000),
        np.array([0.0, 1.0, 3.0]),
        np.array([0.0, np.nan, 2.0]),
        np.array([0.0, 0.0, 0.0]),
        np.arange(10.0)[::-1],
    ],
)
def test_times_that_are_not_even_are_refused(times):
    with raises_naming(ValueError, "times"):
        even_step(times)


def test_files_of_matlab_7_3_are_read(tmp_path):
    content = {
        "frequencies": F.reshape(-1, 1),
        "response": (S**2 * H / 9.80665).reshape(-1, 1, 1),
        "coherence": COHERENCE.reshape(-1, 1),
        "outputs": ["fan.x"],
        "inputs": "fan.f_x",
        "output_units": ["g"],
        "input_units": "N",
        "settings": {"operator": "tester", "averages": 5.0, "inner": {"x": 1.0}},
    }
    check(read_measured(write_mat73(tmp_path / "a.mat", content)), unit="(m/s2)/N", values=S**2 * H)


def test_a_matlab_file_does_not_read_another_file(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["secret"] = np.arange(10.0)
    path = write_mat73(tmp_path / "a.mat", {"time": np.arange(10.0)})
    with h5py.File(path, "r+") as file:
        file["frequencies"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/secret")
    with raises_naming(ValueError, "frequencies", "link"):
        read_measured(path)


@pytest.mark.parametrize(
    "text",
    [
        "frequency [Hz],a" + " " * 20_000 + "b[\n1,2\n",
        "sep=,\nfrequency [Hz]" + "," * 100_000 + "\n1" + "," * 100_000 + "\n",
        "sep=,\nfrequency [Hz]," + ",".join(f"c{k}" for k in range(50_000)) + "\n" + ",".join("1" * 50_001) + "\n",
        "sep=;\nfrequency [Hz];a\n1;1" + "," * 100_000 + "x\n",
    ],
)
def test_wide_tables_and_long_headings_take_no_time(run_python, tmp_path, text):
    """Each took minutes: the number of steps grew with the square or the cube of the length."""
    (tmp_path / "wide.csv").write_text(text)

    def read(path: str) -> bool:
        from amb_analysis.measured.files import read_measured

        try:
            return not read_measured(path).responses
        except ValueError as error:
            return "wide.csv" in str(error)

    assert run_python(read, timeout=30, path=str(tmp_path / "wide.csv"))


ARRAYS = {"inputs": ["fan.f_x"], "outputs": ["fan.x"], "input_units": ["N"], "output_units": ["m"]}


@pytest.mark.parametrize(
    ("stated", "factor"),
    [
        ({}, 1.0),
        ({"frequency_unit": "kHz"}, 1e3),
        ({"frequency_units": ["rad/s"]}, 0.5 / np.pi),
        ({"units.frequencies": "rpm"}, 1 / 60.0),
    ],
)
def test_frequencies_of_arrays_are_in_their_stated_unit(tmp_path, stated, factor):
    f = np.linspace(10.0, 90.0, 5)
    np.savez(tmp_path / "a.npz", frequencies=f, response=np.ones((5, 1, 1)), **ARRAYS, **stated)
    (curve,) = read_measured(tmp_path / "a.npz").responses
    np.testing.assert_allclose(curve.frequencies, factor * f, rtol=1e-12)


@pytest.mark.parametrize("stated", [{"frequency_unit": "m"}, {"response_unit": "mm/N"}, {"f_units": "kHz"}])
def test_a_unit_of_arrays_that_is_not_used_is_refused(tmp_path, stated):
    f = np.linspace(10.0, 90.0, 5)
    np.savez(tmp_path / "a.npz", frequencies=f, response=np.ones((5, 1, 1)), **ARRAYS, **stated)
    with raises_naming(ValueError, "a.npz", "Hz" if "frequency_unit" in stated else next(iter(stated))):
        read_measured(tmp_path / "a.npz")


@pytest.mark.parametrize("key", ["time_unit", "units.time"])
def test_times_of_arrays_are_in_their_stated_unit(tmp_path, key):
    force = np.random.default_rng(0).standard_normal(4000)
    channels = {"u": force, "y": 5.0 * force, "units.u": "N", "units.y": "m"}
    np.savez(tmp_path / "t.npz", time=0.1 * np.arange(4000), **channels, **{key: "ms"})
    (curve,) = read_measured(tmp_path / "t.npz", inputs=["u"]).responses
    assert curve.frequencies[-1] == pytest.approx(5000.0, rel=1e-2)
