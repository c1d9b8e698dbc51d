"""Axes of a sweep, and the points that they span."""

import numpy as np
import pytest

from amb_sweeps.axes import Axis, parse_vary, read_variations
from amb_sweeps.sampling import sample_plan
from tests.support.messages import raises_naming


def only(text):
    (variation,) = read_variations(parse_vary([text]))
    return variation


def test_a_range_has_its_ends_and_its_unit():
    axis = only("rotor_contact.d1.u=1 g.m:60 g.m:40")
    (column,) = axis.columns
    assert (len(axis), column.values[0], column.values[-1], column.unit) == (40, 1.0, 60.0, "g.m")
    assert axis.settings(39) == {"rotor_contact.d1.u": "60.0 g.m"}


def test_the_unit_of_the_stop_holds_for_the_range():
    (column,) = only("rotor_contact.rb1.clearance=500 um:0.7 mm:3").columns
    assert column.unit == "mm"
    np.testing.assert_allclose(column.values, [0.5, 0.6, 0.7])


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("p.mu=0.1:0.5:5", (0.1, 0.2, 0.3, 0.4, 0.5), ""),
        ("p.gap=0.1 mm:0.5 mm:5", (0.1, 0.2, 0.3, 0.4, 0.5), "mm"),
        ("p.gap=100 um:0.5 mm:5", (0.1, 0.2, 0.3, 0.4, 0.5), "mm"),
        ("p.gap=3.3 um:0.0077 mm:5", (0.0033, 0.0044, 0.0055, 0.0066, 0.0077), "mm"),
        ("p.gap=3.3 um,0.0077 mm", (3.3, 7.7), "um"),
        ("p.k=0.3:-0.3:7", (0.3, 0.2, 0.1, 0.0, -0.1, -0.2, -0.3), ""),
        ("p.k=1e-9:7e-9:7", (1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9, 7e-9), ""),
        ("p.k=0:1:4", (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0), ""),
        ("p.k=0.1:0.7:1", (0.1,), ""),
    ],
)
def test_a_grid_holds_the_numbers_that_a_user_would_write(text, values, unit):
    """Equal bits, so that a value can be selected from a result; numpy.linspace gives 0.30000000000000004."""
    (column,) = only(text).columns
    assert (column.values, column.unit) == (values, unit)


def test_numbers_without_a_unit_stay_numbers():
    assert only("p.w=60:300:3").settings(1) == {"p.w": 180.0}


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("p.w=90,120", (90.0, 120.0), ""),
        ("p.w=10 Hz,12 Hz", (10.0, 12.0), "Hz"),
        ("d.u=1 g.m,0.002 kg.m", (1.0, 2.0), "g.m"),
        ("p.w=-90,1e-3", (-90.0, 1e-3), ""),
        ("d.f=10 s-1,-0.5 s-1", (10.0, -0.5), "s-1"),
        ("fmu.c=2-3.fmu,2026-01-02.fmu", ("2-3.fmu", "2026-01-02.fmu"), ""),
        ("rotor_contact.contact.impact_law=nodal,newton", ("nodal", "newton"), ""),
        ("rolac_controller.rolac_enable=true,false", ("true", "false"), ""),
    ],
)
def test_a_list_is_of_numbers_in_one_unit_or_of_texts(text, values, unit):
    (column,) = only(text).columns
    assert (column.values, column.unit) == (values, unit)


@pytest.mark.parametrize("name", ["one.a=b", "one.der(x)", "axle.motor.pipe[1].T 2", "one.'p=q'"])
def test_variables_of_any_fmu_can_be_varied(name):
    assert only(f"{name}=1:3:3").settings(1) == {name: 2.0}
    assert only(f"{name} = 1 mm,2 mm").settings(0) == {name: "1.0 mm"}


def test_a_file_may_have_an_equals_sign_in_its_name(tmp_path):
    file = tmp_path / "a=b.toml"
    file.write_text('[PID]\n"c.on" = false\n')
    assert only(f"control=@{file}").columns[0].values == ("PID",)


def test_variables_varied_together_share_an_axis():
    axis = only("p.w=60:300:3 & rotor_contact.d1.u=3 g.m,2 g.m,1 g.m")
    assert axis.settings(2) == {"p.w": 300.0, "rotor_contact.d1.u": "1.0 g.m"}


def test_alternatives_set_the_values_of_their_labels(tmp_path):
    file = tmp_path / "controls.toml"
    file.write_text('[PID]\n"c.on" = false\n[ROLAC]\n"c.on" = true\n"c.mode" = 1\n')
    axis = only(f"control=@{file}")
    assert axis.columns[0].values == ("PID", "ROLAC")
    assert axis.settings(1) == {"c.on": True, "c.mode": 1}


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("p.w", ("p.w",)),
        ("p.w=", ("p.w",)),
        ("p.w=a:b:3", ("a:b:3", "START:STOP:COUNT")),
        ("p.w=200-300", ("p.w = 200-300", "START:STOP:COUNT", "200:300:11")),
        ("p.w=200 rad/s - 300 rad/s", ("200 rad/s - 300 rad/s", "START:STOP:COUNT")),
        ("p.w=90,200..300 rpm", ("200..300 rpm", "START:STOP:COUNT")),
        ("d.u=1.5 to 60 g.m", ("1.5 to 60 g.m", "START:STOP:COUNT")),
        ("p.w=200-300:3", ("200-300:3", "START:STOP:COUNT")),
        ("p.w=1:2:0", ("count", "'0'", "1")),
        ("p.w=1:2:3:4", ("range",)),
        ("p.w=1:1e999:3", ("ends", "finite")),
        ("O mega=1:2:3", ("O mega",)),
        ("p.w=1 kg:2 s:3", ("p.w",)),
        ("p.w=1:2:3 & x.y=1,2", ("p.w 3", "x.y 2")),
        ("control=@missing.toml", ("missing.toml",)),
    ],
)
def test_an_error_names_the_fault_and_the_allowed_values(text, facts):
    with raises_naming(ValueError, *facts):
        read_variations(parse_vary([text]))


def test_a_variable_on_two_axes_is_refused():
    with raises_naming(ValueError, "p.w", "twice"):
        read_variations(parse_vary(["p.w=1,2", "p.w=3,4 & x.y=5,6"]))


def test_a_grid_is_the_product_of_its_axes():
    design = sample_plan({"p.w": [60, 90], "x.y": [1, 2, 3], "control": {"a": {"x.z": 1}, "b": {}}})
    assert (design.shape, design.size) == ((2, 3, 2), 12)
    assert design.settings(0) == {"p.w": 60, "x.y": 1, "x.z": 1}
    assert design.settings(11) == {"p.w": 90, "x.y": 3}
    assert {design.settings(n)["x.y"] for n in design.corners()} == {1, 2, 3}


@pytest.mark.parametrize("method", ["lhs", "sobol"])
def test_a_sample_fills_each_stratum_and_repeats_with_its_seed(method):
    vary = {"p.w": "60:300", "x.y": "1 mm:2 mm"}
    design = sample_plan(vary, f"{method}:16", seed=3)
    (axis,) = design.axes
    for column, low, high in zip(axis.columns, (60, 1), (300, 2), strict=True):
        strata = np.floor(16 * (np.array(column.values) - low) / (high - low))
        assert sorted(strata) == list(range(16))
    assert sample_plan(vary, f"{method}:16", seed=3) == design
    assert sample_plan(vary, f"{method}:16", seed=4) != design


def test_alternatives_see_the_same_samples():
    design = sample_plan({"control": {"a": {}, "b": {"x.z": 1}}, "p.w": "60:300"}, "lhs:5")
    assert design.shape == (2, 5)
    assert [design.settings(n)["p.w"] for n in range(5)] == [design.settings(n + 5)["p.w"] for n in range(5)]


def test_ranges_that_vary_together_share_their_samples():
    (axis,) = sample_plan({"p.w & x.y": ["0:10", "0:1"]}, "sobol:8").axes
    assert isinstance(axis, Axis)
    np.testing.assert_allclose(np.array(axis.columns[0].values), 10.0 * np.array(axis.columns[1].values))


@pytest.mark.parametrize(
    ("vary", "sample", "facts"),
    [
        ({"p.w": "1:2"}, "grid", ("p.w", "count")),
        ({"p.w": "1:2:3"}, "lhs:4", ("sample",)),
        ({"p.w": "1:2"}, "lhs:0", ("grid", "lhs:N")),
        ({"p.w": "1:2"}, "halton:4", ("grid", "lhs:N")),
        ({"p.w": "1:2"}, "saltelli:6", ("power of 2",)),
        ({}, "grid", ("nothing",)),
        ({"a.a": "1:2:9999", "b.b": "1:2:9999"}, "grid", ("points",)),
    ],
)
def test_an_impossible_design_is_refused(vary, sample, facts):
    with raises_naming(ValueError, *facts):
        sample_plan(vary, sample)


@pytest.mark.parametrize("values", ["60:300:60", "60:300", "90,120", "0,90"])
@pytest.mark.parametrize("name", ["Omega", "rotor_contact.Omega"])
def test_a_text_of_speeds_needs_a_unit(name, values):
    """9167 rpm were run for 960: of a text nobody knows the unit, and numbers of Python are in rad/s."""
    with raises_naming(ValueError, name, values, "rpm", "rad/s"):
        read_variations({name: values})


@pytest.mark.parametrize("values", ["60:300 rpm:60", "60 Hz:300 Hz", "90,120 rad/s", "0", [90, 120.0]])
def test_speeds_with_a_unit_numbers_of_python_and_zero_are_speeds(values):
    assert read_variations({"Omega": values})
