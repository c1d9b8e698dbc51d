"""Universal files as instruments write them: units of set 164 and abscissa, padding, repeated records, damping."""

from __future__ import annotations

import numpy as np
import pytest

from amb_analysis.measured.files import read_measured
from amb_cosim import studies
from tests.support.messages import raises_naming

pyuff = pytest.importorskip("pyuff")

F = np.arange(5.0, 100.0, 0.5)
S = 2j * np.pi * F
H = 1.0 / (3.0 * S**2 + 40.0 * S + 3.0 * (2 * np.pi * 42.0) ** 2)  # m/N
DISPLACEMENT, VELOCITY, ACCELERATION, FORCE, FREQUENCY, RPM, TIME = 8, 11, 12, 13, 18, 19, 17  # types of data
NAME = "3.x/7.x"


def function(data=H, kind=DISPLACEMENT, labels=("", ""), abscissa=(FREQUENCY, ""), **values):
    base = {"type": 58, "func_type": 4, "rsp_node": 3, "rsp_dir": 1, "ref_node": 7, "ref_dir": 1, "x": F, "id1": "NONE"}
    base |= {"abscissa_spacing": 1, "abscissa_spec_data_type": abscissa[0], "abscissa_axis_units_lab": abscissa[1]}
    base |= {"ordinate_spec_data_type": kind, "ordinate_axis_units_lab": labels[0]}
    base |= {"orddenom_spec_data_type": FORCE, "orddenom_axis_units_lab": labels[1]}
    return base | {"data": data, "binary": 0} | values


def units(length, force, code=9):
    scale = {"length": length, "force": force, "temp": 1.0, "temp_offset": 273.15}
    return {"type": 164, "units_code": code, "units_description": "units", "temp_mode": 1} | scale


def record(data, kind, label, step=1e-3, node=3, abscissa=(TIME, ""), **values):
    x = np.arange(len(data)) * step
    ends = {"func_type": 1, "rsp_node": node, "ref_node": 0, "ref_dir": 0, "orddenom_spec_data_type": 0}
    return function(data, kind, (label, ""), abscissa, x=x, **ends, **values)


@pytest.fixture
def written(tmp_path):
    """Writes sets to a file and returns it."""

    def write(*sets):
        path = tmp_path / "a.uff"
        pyuff.UFF(str(path)).write_sets(list(sets), "overwrite")
        return path

    return write


@pytest.mark.parametrize(
    ("length", "force", "kind", "scale"),
    [
        (1e3, 1.0, DISPLACEMENT, 1e3),  # mm and N
        (1e3, 1e3, DISPLACEMENT, 1.0),  # mm and mN
        (39.37007874, 0.2248089431, DISPLACEMENT, 39.37007874 / 0.2248089431),  # inch and pound-force
        (1e3, 1.0, ACCELERATION, 1e3 * S**2),
        (1e2, 1.0, VELOCITY, 1e2 * S),
    ],
)
def test_set_164_scales_data_without_labels(written, length, force, kind, scale):
    """Responses in mm/N were read as m/N, 60 dB too large."""
    (curve,) = read_measured(written(units(length, force), function(scale * H, kind))).responses
    order = {DISPLACEMENT: 0, VELOCITY: 1, ACCELERATION: 2}[kind]
    np.testing.assert_allclose(curve.values, S**order * H, rtol=1e-9)


def test_each_set_has_the_units_before_it(written):
    sets = (units(1e3, 1.0), function(1e3 * H), units(1.0, 1.0), function(H, rsp_node=4), function(H, rsp_node=5))
    for curve in read_measured(written(*sets)).responses:
        np.testing.assert_allclose(curve.values, H, rtol=1e-9)
    np.testing.assert_allclose(read_measured(written(function(1e3 * H), units(1e3, 1.0))).responses[0].values, H)


@pytest.mark.parametrize(
    ("sets", "facts"),
    [
        ((units(1.0, 1.0), function(labels=("mm", "N"))), ("'mm'", "set 164", "length")),
        ((function(labels=("g", "N")),), ("'g'", "type of data 8", "m")),
        ((function(kind=0),), ("type 0",)),
        ((function(labels=("mm/N", "kN")),), ("mm/N", "kN")),
        ((units(0.0, 1.0), function()), ("set 164", "> 0")),
    ],
)
def test_units_that_contradict_each_other_are_refused(written, sets, facts):
    with raises_naming(ValueError, *facts):
        read_measured(written(*sets))


def test_a_stated_unit_replaces_contradicting_labels(written):
    path = written(units(1.0, 1.0), function(1e6 * H, labels=("mm", "N")))
    (curve,) = read_measured(path, units={NAME: "um/N"}).responses
    np.testing.assert_allclose(curve.values, H, rtol=1e-9)


@pytest.mark.parametrize("label", ["mm/N", "(mm)/N"])
@pytest.mark.parametrize("denominator", ["", "N"])
def test_a_label_may_be_the_quotient_of_both_units(written, label, denominator):
    (curve,) = read_measured(written(function(1e3 * H, labels=(label, denominator)))).responses
    np.testing.assert_allclose(curve.values, H, rtol=1e-9)
    path = written(function(S**2 * H / 9.80665, ACCELERATION, ("g/N", denominator)))
    assert read_measured(path).responses[0].unit == "(m/s2)/N"


@pytest.mark.parametrize(
    ("abscissa", "x"),
    [
        ((FREQUENCY, "kHz"), F / 1e3),
        ((FREQUENCY, "rad/s"), 2 * np.pi * F),
        ((FREQUENCY, "Hertz"), F),
        ((FREQUENCY, "1/min"), 60.0 * F),
        ((RPM, "RPM"), 60.0 * F),
        ((RPM, "NONE"), 60.0 * F),
        ((0, ""), F),
    ],
)
def test_frequencies_have_the_unit_of_the_abscissa(written, abscissa, x):
    """Frequencies in kHz and rpm were read as Hz."""
    coherence = function(np.full(len(F), 0.9), func_type=6, abscissa=abscissa, x=x)
    (curve,) = read_measured(written(function(abscissa=abscissa, x=x), coherence)).responses
    np.testing.assert_allclose(curve.frequencies, F, rtol=1e-5)  # the step has six digits in the file
    np.testing.assert_allclose(curve.coherence, 0.9)


@pytest.mark.parametrize("abscissa", [(RPM, "Hz"), (20, ""), (TIME, ""), (FREQUENCY, "s"), (FREQUENCY, "lines")])
def test_an_abscissa_that_is_no_frequency_is_refused(written, abscissa):
    path = written(function(abscissa=abscissa))
    with raises_naming(ValueError, "frequency"):
        read_measured(path)
    (curve,) = read_measured(path, units={"frequency": "Hz"}).responses
    np.testing.assert_allclose(curve.frequencies, F, rtol=1e-5)


@pytest.mark.parametrize(("label", "scale"), [("ms", 1e3), ("s", 1.0), ("NONE", 1.0), ("us", 1e6), ("sec", 1.0)])
def test_times_have_the_unit_of_the_abscissa(written, label, scale):
    force = np.random.default_rng(1).standard_normal(4000)
    sets = [record(data, kind, "", scale * 1e-3, node, (TIME, label)) for data, kind, node in
            ((force, FORCE, 7), (2.0 * force, DISPLACEMENT, 3))]  # fmt: skip
    (curve,) = read_measured(written(*sets), inputs=["7.x"]).responses
    assert curve.frequencies[-1] == pytest.approx(500.0 - curve.frequencies[0], rel=1e-3)
    np.testing.assert_allclose(curve.values, 2.0, rtol=1e-6)


def test_the_driving_point_of_a_record_has_a_force_and_a_motion(written):
    force = np.random.default_rng(1).standard_normal(4000)
    path = written(record(force, FORCE, "N"), record(2.0 * force, ACCELERATION, "g"))
    (curve,) = read_measured(path, inputs=["3.x"]).responses
    assert (curve.name, curve.unit) == ("3.x/3.x", "(m/s2)/N")
    np.testing.assert_allclose(curve.values, 2.0 * 9.80665, rtol=1e-6)


def test_repeated_records_of_a_channel_are_averaged(written):
    """Each repetition has a sign of its own; a segment across two of them would not have the response."""
    blows = np.random.default_rng(1).standard_normal((5, 2000)) * np.array([1, -1, 1, -1, 1])[:, None]
    responses = np.array([np.convolve(blow, [0.0, 0.5, 0.25])[:2000] for blow in blows])
    sets = [item for f, y in zip(blows, responses, strict=True) for item in
            (record(f, FORCE, "N", node=7), record(y, DISPLACEMENT, "m"))]  # fmt: skip
    (curve,) = read_measured(written(*sets), inputs=["7.x"], segment=1.0).responses
    z = np.exp(-2j * np.pi * curve.frequencies * 1e-3)
    np.testing.assert_allclose(curve.values, 0.5 * z + 0.25 * z**2, atol=2e-3)
    assert curve.coherence.min() > 0.999
    with raises_naming(ValueError, "7.x", "5", "3.x", "4"):
        read_measured(written(*sets[:-1]), inputs=["7.x"])


def test_repeated_responses_have_their_own_coherence(written):
    gammas = [np.full(len(F), value) for value in (0.7, 0.9)]
    sets = [function(scale * H) for scale in (1.0, 2.0)] + [function(gamma, func_type=6) for gamma in gammas]
    curves = read_measured(written(*sets)).responses
    for curve, scale, gamma in zip(curves, (1.0, 2.0), gammas, strict=True):
        np.testing.assert_allclose(curve.values, scale * H, rtol=1e-9)
        np.testing.assert_allclose(curve.coherence, gamma)


def at_node_0(data, number, date="01-Jan-20", **values):
    nodes = {"rsp_node": 0, "rsp_dir": 0, "ref_node": 0, "ref_dir": 0, "id1": "test", "id3": date}
    return function(data, ACCELERATION, ("", ""), **{**nodes, "id5": f"H1 : # {number} / # 1", **values})


def test_functions_of_node_0_with_other_texts_are_other_points(written):
    """They were repetitions of one point, so that MAC compared one shape with itself."""
    sets = [at_node_0(scale * H, k + 2) for k, scale in enumerate((1.0, -0.5, 0.2))]
    path = written(*sets, at_node_0(np.full(len(F), 0.9), 3, func_type=6))
    with raises_naming(ValueError, "3 points", "0 (1)", "'H1 : # 2 / # 1'", "0 (3)", "'H1 : # 4 / # 1'", "channels"):
        read_measured(path)
    with raises_naming(ValueError, "2 points", "0 (2)", "0 (3)"):
        read_measured(path, {"0 (1)": "0.1 m.x", "0": "0.1 m.x"})
    places = {f"0 ({k})": f"0.{k} m.x" for k in (1, 2, 3)}
    curves = read_measured(written(*sets), {**places, "0": "0.1 m.f_x"}).responses
    assert [curve.name for curve in curves] == [f"0.{k} m.x/0.1 m.f_x" for k in (1, 2, 3)]
    for curve, scale in zip(curves, (1.0, -0.5, 0.2), strict=True):
        np.testing.assert_allclose(curve.values, scale * H, rtol=1e-9)


@pytest.mark.parametrize("numbers", [(2, 3, 4), (3, 4)])
def test_coherences_of_node_0_belong_to_the_responses_only_if_each_has_one(written, numbers):
    sets = [at_node_0(scale * H, k + 2) for k, scale in enumerate((1.0, -0.5, 0.2))]
    gammas = [at_node_0(np.full(len(F), 0.1 * k), k, func_type=6) for k in numbers]
    measured = read_measured(written(*sets, *gammas), {f"0 ({k})": f"0.{k} m.x" for k in (1, 2, 3)})
    expected = [0.1 * k for k in numbers] if len(numbers) == 3 else [None] * 3
    assert [c.coherence if c.coherence is None else c.coherence[0] for c in measured.responses] == pytest.approx(
        expected
    )
    assert len(measured.warnings) == (0 if len(numbers) == 3 else 1)


def test_functions_of_node_0_with_the_same_text_are_repetitions(written):
    curves = read_measured(written(at_node_0(H, 2), at_node_0(1.1 * H, 2, "02-Jan-20"))).responses
    assert [curve.name for curve in curves] == ["0/0", "0/0"]


def test_records_of_node_0_with_other_texts_are_other_channels(written):
    """Records of equal length were joined to one record of a single channel."""
    force = np.random.default_rng(1).standard_normal(4000)
    sets = [record(scale * force, kind, "", node=0, rsp_dir=0, id5=f"Time #{k}") for k, (scale, kind) in
            enumerate(((1.0, FORCE), (2.0, ACCELERATION), (3.0, ACCELERATION)), 1)]  # fmt: skip
    with raises_naming(ValueError, "3 points", "0 (2)", "'Time #2'"):
        read_measured(written(*sets), inputs=["0 (1)"])
    places = {"0 (1)": "wheel.f_x", "0 (2)": "wheel.x", "0 (3)": "0.1 m.x"}
    curves = read_measured(written(*sets), places, inputs=["0 (1)"]).responses
    assert [curve.name for curve in curves] == ["wheel.x/wheel.f_x", "0.1 m.x/wheel.f_x"]
    np.testing.assert_allclose(curves[1].values, 3.0, rtol=1e-6)


def test_coherence_without_a_reference_belongs_to_its_output(written):
    """Its reference is node 0, because it is that with all inputs; it was not used, without a word."""
    gamma = function(np.full(len(F), 0.7), func_type=6, ref_node=0, ref_dir=0)
    measured = read_measured(written(function(), function(rsp_node=4), gamma))
    assert measured.warnings == ()
    np.testing.assert_allclose(measured.responses[0].coherence, 0.7)
    assert measured.responses[1].coherence is None


@pytest.mark.parametrize("changed", [{"rsp_node": 9}, {"x": F + 0.1}, {"x": F[:-1], "data": np.full(len(F) - 1, 0.9)}])
def test_coherence_that_belongs_to_no_response_is_named(written, changed):
    gamma = function(**{"data": np.full(len(F), 0.9), "func_type": 6, **changed})
    (notice,) = read_measured(written(function(), gamma)).warnings
    assert ("9.x/7.x" if "rsp_node" in changed else NAME) in notice


def test_a_real_response_is_refused(written):
    """Without its phase, a resonance has no damping."""
    with raises_naming(ValueError, NAME, "real", "phases"):
        read_measured(written(function(np.abs(H))))


@pytest.mark.parametrize("width", [80, 82])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_lines_that_are_filled_with_blanks_are_read(written, width, newline):
    n = len(F) - 1 if len(F) % 2 == 0 else len(F)  # an odd number of values, so that the last line is half full
    path = written(function(H[:n], x=F[:n]), mode(42.0, 0.01, 0.0))
    lines = [line.ljust(width) for line in path.read_text().splitlines()]
    path.write_bytes((newline.join(lines) + newline).encode())
    measured = read_measured(path)
    np.testing.assert_allclose(measured.responses[0].values, H[:n], rtol=1e-9)
    assert measured.modes.damping_ratios == [0.01]


def test_values_after_the_announced_number_are_filling(written):
    path = written(function(np.concatenate([H, [0.0, 0.0]]), x=np.append(F, [100.0, 100.5])))
    path.write_text(path.read_text().replace(f"{len(F) + 2:10}", f"{len(F):10}", 1))
    (curve,) = read_measured(path).responses
    np.testing.assert_allclose(curve.values, H, rtol=1e-9)


def mode(frequency, viscous, hysteretic):
    place = {"node_nums": np.array([1, 2]), **{f"r{k}": np.array([1.0, 2.0]) for k in (1, 2, 3)}}
    kind = {"type": 55, "analysis_type": 2, "data_ch": 2, "spec_data_type": 8, "load_case": 1, "mode_n": 1}
    return {**kind, **place, "freq": frequency, "modal_damp_vis": viscous, "modal_damp_his": hysteretic}


@pytest.mark.parametrize(
    ("viscous", "hysteretic", "ratio"), [(0.0, 0.02, 0.01), (0.01, 0.0, 0.01), (0.01, 0.02, 0.01), (0.0, 0.0, 0.0)]
)
def test_half_of_a_hysteretic_loss_factor_is_the_damping_ratio(written, viscous, hysteretic, ratio):
    modes = read_measured(written(mode(159.15, viscous, hysteretic))).modes
    assert modes.frequencies == pytest.approx([159.15])
    assert modes.damping_ratios == pytest.approx([ratio])


def test_two_damping_ratios_that_differ_are_refused(written):
    with raises_naming(ValueError, "159.15 Hz", "0.01", "0.05"):
        read_measured(written(mode(159.15, 0.01, 0.05)))


def test_nodes_of_an_instrument_are_not_positions(written, tmp_path):
    """Nodes 3 and 7 were positions in m on a shaft of 8 m, without a word."""
    rotor = tmp_path / "long.toml"
    rotor.write_text(
        'name = "long"\n[shaft]\nyoungs_modulus = 2.1e11\ndensity = 7800.0\npoissons_ratio = 0.3\n'
        "[[shaft.sections]]\nlength = 8.0\ndiameter = 0.4\n"
    )
    path = written(function(labels=("m", "N")))
    with raises_naming(ValueError, "7.x", "unit", "channels"):
        studies.response(rotor=rotor, measured=path)
    result = studies.response(rotor=rotor, measured=path, channels={"3.x": "3 m.x", "7.x": "7 m.x"})
    assert list(result.responses) == ["3 m.x/7 m.x"]
