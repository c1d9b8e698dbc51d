"""Units of figures: asked for, or by the size of what is shown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amb_cosim
from amb_cosim.presentation.style import spread
from amb_cosim.presentation.units import force_unit, length_unit, parse_units, speed_unit, spin_text
from amb_cosim.results import plots


def test_small_lengths_are_in_um_and_large_forces_in_kn():
    assert [length_unit(size).name for size in (9e-5, 1.1e-4)] == ["um", "mm"]
    assert [force_unit(size).name for size in (900.0, 1100.0)] == ["N", "kN"]
    assert length_unit(5e-6).of(5e-6) == pytest.approx(5.0)


def test_units_that_are_asked_for_hold_until_the_block_ends():
    with amb_cosim.units("rpm", "mm"):
        assert speed_unit().of(2.0 * math.pi) == pytest.approx(60.0)
        assert length_unit(1e-6).name == "mm"
        assert spin_text(10.0 * math.pi) == "$n$ = 300 rpm"
    assert speed_unit().name == "rad/s"
    assert length_unit(1e-6).name == "um"


@pytest.mark.parametrize(("text", "told"), [("rpm,Hz", "one unit of speed"), ("furlong", "one of rad/s, Hz, rpm")])
def test_units_that_are_none_or_two_of_a_kind_are_refused(text, told):
    with pytest.raises(ValueError, match=told):
        parse_units(text)


def test_a_figure_shows_the_speed_in_the_unit_asked_for(synthetic):
    Omega = synthetic().attrs["speed_rad_s"]
    with amb_cosim.units("Hz"):
        title = plots.Plots(synthetic()).displacement().get_suptitle()
    assert f"{Omega / (2.0 * math.pi):.4g} Hz" in title


def test_a_command_refuses_a_unit_that_is_none(runner):
    ended = runner("study", "campbell", "--units", "furlong")
    assert ended.exit_code == 2
    assert "units = 'furlong' is not allowed" in ended.output


@given(st.lists(st.floats(-1.0, 1.0), max_size=12), st.floats(0.0, 0.5))
def test_labels_keep_their_distance_and_their_order(places, gap):
    found = spread(places, gap)
    order = np.argsort(places, kind="stable")
    assert np.all(np.diff(found[order]) >= gap - 1e-9)
    if places:
        assert found.mean() == pytest.approx(np.mean(places), abs=1e-9)


def test_labels_that_are_apart_stay_where_they_are():
    np.testing.assert_allclose(spread([0.7, 0.1, 0.4], 0.2), [0.7, 0.1, 0.4])
    np.testing.assert_allclose(spread([0.5, 0.5], 0.2), [0.4, 0.6])
