"""The table of receptances in a file: written completely or not at all, for one rotor and one loop."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rig import CONTROLLER, LOOP, SIZES, given_parameters, pack

from amb_cosim.model_constants.controller_data import inverse_receptance
from amb_cosim.model_constants.receptance_file import empty_table, loop_parameters, read_table
from rolac_controller.inner_loop import inner_loop_of
from rolac_controller.pseudo_inverse import svd_work_of, svd_work_size
from rolac_controller.receptance_table import built_table, find_bracket, interpolate, load, table_in_use, table_size
from tests.support.messages import raises_naming

INTERFACE = CONTROLLER.interface


@pytest.fixture
def table(receptance):
    """Three speeds, the middle one with a second harmonic."""
    made = empty_table("rig", LOOP)
    for speed, factor in [(62.83, 1.0), (31.4, 1j), (157.0, 0.5 - 0.5j)]:
        made = made.updated(speed, factor * receptance)
    return made.updated(62.83, 3.0 * receptance, order=2)


def test_a_written_table_is_read_back_to_the_last_bit(table, tmp_path):
    table.write(tmp_path / "new" / "table.toml")
    result = read_table(tmp_path / "new" / "table.toml", "rig", LOOP, loop_parameters(LOOP))
    for name in ("rotor", "sensors", "axes", "parameters"):
        assert getattr(result, name) == getattr(table, name)
    assert [(e.order, e.speed) for e in result.entries] == [(1, 31.4), (1, 62.83), (1, 157.0), (2, 62.83)]
    for a, b in zip(result.entries, table.entries, strict=True):
        np.testing.assert_array_equal(a.receptance, b.receptance)
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["table.toml"]


def test_response_of_an_inner_loop_is_stored_with_its_receptance(table, receptance, tmp_path):
    C = np.arange(32.0).reshape(4, 8) * (1.0 - 2.0j)
    table.updated(31.4, receptance, inner=C).write(tmp_path / "table.toml")
    result = read_table(tmp_path / "table.toml")
    np.testing.assert_array_equal(result.entries[0].inner, C)
    assert result.entries[1].inner is None
    constants = result.constants(LOOP)
    inner = inner_loop_of(constants, SIZES)
    assert [tuple(key) for key in inner.keys] == [(1.0, 31.4)]
    np.testing.assert_array_equal(inner.C, [C])
    np.testing.assert_array_equal(built_table(constants, SIZES).R[0], receptance)


@settings(deadline=None)
@given(name=st.text(st.characters(exclude_categories=["Cs"])))
def test_any_name_of_a_rotor_is_preserved(name, tmp_path_factory):
    path = tmp_path_factory.mktemp("named") / "table.toml"
    empty_table(name, LOOP).write(path)
    assert read_table(path, name).rotor == name


def test_new_receptance_replaces_only_that_of_its_speed(table, receptance):
    changed = table.updated(62.9, 7.0 * receptance)
    assert [(e.order, e.speed) for e in changed.entries] == [(1, 31.4), (1, 62.9), (1, 157.0), (2, 62.83)]
    np.testing.assert_array_equal(changed.entries[1].receptance, 7.0 * receptance)
    np.testing.assert_array_equal(table.entries[1].receptance, receptance)


def test_h_of_a_controller_is_linear_between_speeds_and_constant_beyond(table, receptance):
    constants = table.constants(LOOP)
    inside = table_in_use(np.zeros(table_size(constants)), 0, constants, SIZES)
    assert load(
        built_table(constants, SIZES),
        given_parameters({}),
        inside,
        svd_work_of(np.zeros(svd_work_size(SIZES)), 0, SIZES),
    )
    h = inverse_receptance(receptance)
    middle = 0.5 * (31.4 + 62.83)
    for speed, expected in [(62.83, h), (middle, 0.5 * (h + h / 1j)), (20.0, h / 1j), (200.0, h / (0.5 - 0.5j))]:
        lower, upper, weight, _ = find_bracket(inside, 1.0, speed)
        H = np.zeros((4, 8), dtype=complex)
        interpolate(inside.H[lower], inside.H[upper], weight, H)
        np.testing.assert_allclose(H, expected, rtol=1e-12)


def test_constants_of_a_single_harmonic_are_those_of_pack(receptance):
    speeds, receptances = [50.0, 100.0], [receptance, 1j * receptance]
    table = empty_table("rig", LOOP)
    for speed, r in zip(speeds, receptances, strict=True):
        table = table.updated(speed, r)
    np.testing.assert_array_equal(table.constants(LOOP), pack(speeds, receptances))


def test_empty_table_makes_no_controller():
    with raises_naming(ValueError, "rig", "entry"):
        empty_table("rig", LOOP).constants(LOOP)


@pytest.mark.parametrize(
    ("speed", "is_singular", "facts"),
    [*((speed, False, ("speed",)) for speed in (0.0, -1.0, np.nan, np.inf)), (50.0, True, ("condition number",))],
)
def test_speed_that_is_not_positive_and_singular_receptance_are_not_stored(
    table, receptance, speed, is_singular, facts
):
    if is_singular:
        receptance[:, 3] = receptance[:, 2]
    with raises_naming(ValueError, *facts):
        table.updated(speed, receptance)


def test_every_truncation_is_refused(table, tmp_path):
    path = tmp_path / "table.toml"
    table.write(path)
    text = path.read_text()
    for end in range(0, len(text) - 3, 41):
        path.write_text(text[:end])
        with pytest.raises(ValueError, match=r"table\.toml"):
            read_table(path)


def test_loop_holds_exactly_the_parameters_of_a_receptance():
    assert {"sample_time", "mb2.c_b_y", "chain.delay", "chain.cutoff", "s3.scale", "plane4.offset"} < set(
        loop_parameters(LOOP)
    )
    others = {v.name for v in INTERFACE.of("parameter")} - set(loop_parameters(LOOP))
    assert {
        "rolac.alpha",
        "mb1.i_max_x",
        "chain.seed",
        "chain.noise_rms",
        "s1.weight",
        "identification.average",
    } < others
    assert loop_parameters(LOOP, {"mb1.k_b_x": 3.0, "rolac.alpha": 9.0})["mb1.k_b_x"] == 3.0
    assert "rolac.alpha" not in loop_parameters(LOOP, {"rolac.alpha": 9.0})


def edit(old, new):
    return lambda text: text.replace(old, new, 1)


def with_a_singular_receptance(text):
    lines = text.splitlines()
    for k in [k for k, line in enumerate(lines) if line.startswith("  [")][:16]:
        lines[k] = "  [1.0, 1.0, 0.0, 2.0],"
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (lambda text: "no table at all", ("TOML",)),
        (lambda text: text.rpartition("\n[[receptance]]")[0], ("3 receptances", "entries", "4")),
        (with_a_singular_receptance, ("receptance[0]", "31.4 rad/s", "condition number")),
        (edit("receptances 2", "receptances 1"), ("format", "'amb-cosim receptances 1'")),
        (edit('rotor = "rig"', "rotor = 3"), ("rotor", "3", "string")),
        (edit("sample_time = 0.00025", "sample_time = 'fast'"), ("loop.sample_time", "'fast'", "number")),
        (edit("speed = 31.4", "speed = -31.4"), ("receptance[0].speed", "-31.4 rad/s", "> 0 rad/s")),
        (edit("speed = 31.4", "speed = nan"), ("receptance[0].speed", "nan rad/s")),
        (edit("speed = 31.4", "speed = 70.0"), ("ascending speed",)),
        (edit("order = 1", "order = 0"), ("receptance[0].order = 0", ">= 1")),
        (edit("real = [\n  [", "real = [\n  [1.0, "), ("rows of equal length",)),
        (edit("real = [\n  [", "real = [\n  ['x', "), ("rows of equal length",)),
        (edit("imaginary", "imag"), ("receptance[0].imaginary",)),
        (edit("[[receptance]]", "[[receptance]]\ninner_real = [[1.0]]"), ("inner_real", "inner_imaginary", "together")),
        (
            edit("[[receptance]]", "[[receptance]]\ninner_real = [[1.0]]\ninner_imaginary = [[1.0]]"),
            ("receptance[0]", "inner_real", "1 rows of 1 numbers", "4 rows of 8 numbers"),
        ),
        (
            edit("real = [\n  [", "real = [\n  [inf, 1.0, 1.0, 1.0], #"),
            ("receptance[0].real", "rows of equal length", "finite"),
        ),
    ],
)
def test_file_that_is_no_table_is_refused_with_its_fault(table, tmp_path, change, facts):
    path = tmp_path / "table.toml"
    table.write(path)
    path.write_text(change(path.read_text().replace('"sample_time"', "sample_time")))
    with raises_naming(ValueError, *facts):
        read_table(path)


@pytest.mark.parametrize("make", [lambda p: None, lambda p: p.write_bytes(b"\xff\xfe\x00"), lambda p: p.mkdir()])
def test_unreadable_file_is_refused_with_its_path(tmp_path, make):
    path: Path = tmp_path / "table.toml"
    make(path)
    with raises_naming(ValueError, str(tmp_path / "table.toml")):
        read_table(path)
