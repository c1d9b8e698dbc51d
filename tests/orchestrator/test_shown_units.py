"""Display units of figures, chosen by the user or by the size of the values; figures of pages as data."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

import amb_cosim
from amb_assessment.reporting.panels import Panel, curve, panel_of
from amb_cosim.presentation.style import spread
from amb_cosim.presentation.text_tables import rendered, text_table
from amb_cosim.presentation.units import (
    force_unit,
    frequency_unit,
    length_unit,
    parse_units,
    relabelled,
    speed_unit,
    spin_text,
)


def test_small_lengths_are_in_um_and_large_forces_in_kn():
    assert [length_unit(size).name for size in (9e-5, 1.1e-4)] == ["um", "mm"]
    assert [force_unit(size).name for size in (900.0, 1100.0)] == ["N", "kN"]
    assert length_unit(5e-6).of(5e-6) == pytest.approx(5.0)


def test_chosen_display_units_apply_until_the_block_ends():
    with amb_cosim.units("rpm", "mm"):
        assert speed_unit().of(2.0 * math.pi) == pytest.approx(60.0)
        assert length_unit(1e-6).name == "mm"
        assert spin_text(10.0 * math.pi) == "$n$ = 300 rpm"
    assert (speed_unit().name, frequency_unit().name) == ("rpm", "Hz")
    assert length_unit(1e-6).name == "um"


@pytest.mark.parametrize(("text", "expected"), [("rpm,Hz", "one unit of speed"), ("furlong", "one of rad/s, Hz, rpm")])
def test_unknown_and_conflicting_display_units_are_refused(text, expected):
    with pytest.raises(ValueError, match=expected):
        parse_units(text)


@pytest.mark.parametrize(
    ("label", "expected", "factor"),
    [
        ("speed (1/min)", "speed (Hz)", 1.0 / 60.0),
        ("N", "kN", 1e-3),
        ("peak to peak (um)", "peak to peak (um)", 1.0),
        ("stiffness (N/m)", "stiffness (N/m)", 1.0),
        ("r / C_r", "r / C_r", 1.0),
        ("force at a step (N) of 5", "force at a step (N) of 5", 1.0),
        ("force (N)\nof a step", "force (N)\nof a step", 1.0),
    ],
)
def test_an_axis_of_a_page_has_the_chosen_unit(label, expected, factor):
    with amb_cosim.units("Hz", "kN"):
        assert relabelled(label, "speed", "force", "length") == (expected, pytest.approx(factor))


@given(st.lists(st.floats(-1.0, 1.0), max_size=12), st.floats(0.0, 0.5))
def test_labels_keep_their_distance_and_their_order(places, gap):
    result = spread(places, gap)
    order = np.argsort(places, kind="stable")
    assert np.all(np.diff(result[order]) >= gap - 1e-9)
    if places:
        assert result.mean() == pytest.approx(np.mean(places), abs=1e-9)


@given(st.lists(st.floats(-1.0, 2.0), min_size=1, max_size=11))
def test_labels_between_bounds_are_as_near_to_their_places_as_possible(places):
    result = np.sort(spread(places, 0.1, 0.0, 1.0))
    distances = {"type": "ineq", "fun": lambda at: np.diff(at, prepend=-0.1, append=1.1) - 0.1}
    start, wanted = np.linspace(0.0, 1.0, len(places)), np.sort(places)
    best = minimize(lambda at: np.sum((at - wanted) ** 2), start, constraints=distances, method="SLSQP", tol=1e-14)
    np.testing.assert_allclose(result, best.x, atol=1e-4)


def test_a_curve_with_gaps_is_data_of_json():
    gaps, empty = curve("gaps", [0.0, 1.0, 2.0], [np.nan, 3.0, -2.0]), curve("nothing", [0.0], [np.nan])
    panel = Panel("Radius", "t (s)", "r (m)", (gaps, empty))
    data = json.loads(json.dumps(panel.as_data(), allow_nan=False))
    assert data["least"] == -2.0
    np.testing.assert_array_equal(panel_of(data).curves[0].y, gaps.y)


def test_tables_write_micrometres_and_microseconds_with_their_sign():
    table = text_table("Stiffness (N/um)", ("step (us)", "maximum", "displacement (um)"))
    assert table.title == "Stiffness (N/µm)"
    assert [column.header for column in table.columns] == ["step (µs)", "maximum", "displacement (µm)"]


def test_columns_of_a_table_have_the_chosen_units_but_places_keep_theirs():
    headings = ("forces (N)", "orbit (mm)", "at (Hz)", "z (mm)", "node at (m)", "force (N), at (rpm)")
    with amb_cosim.units("kN", "um", "rpm"):
        table = text_table("Runs", headings, [("1481, 785.3", "0.12", "-", "60", "0.06", "9 at 600")])
    assert [column.header for column in table.columns] == ["forces (kN)", "orbit (µm)", "at (rpm)", *headings[3:]]
    assert [next(column.cells) for column in table.columns] == [
        "1.481, 0.7853",
        "120",
        "-",
        "60",
        "0.06",
        "9 at 600",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("9,600-12,000 rpm", "160-200 Hz"),
        ("from 60 to 120 1/min, 0.1 mm", "from 1 to 2 Hz, 100 \N{MICRO SIGN}m"),
        ("at 60 rpm: 12 \N{MICRO SIGN}m", "at 1 Hz: 12 \N{MICRO SIGN}m"),
        ("a force of 1500 N.", "a force of 1.5 kN."),
        ("z = 12 mm, 3 N/m, 2 mm/s, 4 N.m, 5 mm2, G 2.5", "z = 12 mm, 3 N/m, 2 mm/s, 4 N.m, 5 mm2, G 2.5"),
    ],
)
def test_sentences_have_the_chosen_units_but_compounds_and_places_keep_theirs(text, expected):
    with amb_cosim.units("Hz", "um", "kN"):
        assert rendered([text]).rstrip() == expected
    assert rendered([text]).rstrip() == text
