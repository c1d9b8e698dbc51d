"""Quantities of a run, against a synthetic run with known values."""

import pytest

from amb_assessment.reporting.panels import MOST_POINTS, curve
from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.results.places import RotorPlaces
from source_check.quantities import quantities_of_runs
from source_check.requests import QuantityRequest, evaluate
from tests.support.messages import raises_naming

SAMPLE = 0.011  # cycles; what a begin or an end can be off
QUANTITIES = quantities_of_runs()

KNOWN = {
    "peak force": ("peak_force", {"site": "rb1"}, 3000.0),
    "force in a window": ("peak_force", {"site": "rb2", "begin": 8.5, "end": 9.0}, 0.0),
    "share of the loaded time": ("contact_share", {"states": "both"}, 1.0 / 5.0),
    "share of two states": ("contact_share", {"states": "RB1, both"}, 3.0 / 5.0),
    "longest spell": ("longest_spell", {"states": "RB1,both"}, 3.0),
    "spell broken by another state": ("longest_spell", {"states": "RB1"}, 1.0),
    "first contact": ("first_contact", {}, 6.0),
    "last contact": ("last_contact", {}, 9.0),
    "first contact after the step": ("first_contact", {"since": 5.0}, 1.0),
    "last contact after another cycle": ("last_contact", {"since": 7.5}, 1.5),
    "the other retainer": ("second_site_after", {}, 1.0),
    "rolling after the step": ("rolling_from", {"since": 5.0}, 3.0),
    "clearance": ("parameter", {"component": "rotor_contact", "name": "rb1.clearance"}, 0.75e-3),
    "duration": ("contact_duration", {}, 3.0),
    "first spell": ("first_spell", {}, 3.0),
    "first spell in a state": ("first_spell", {"states": "both"}, 1.0),
    "first spell after a cycle": ("first_spell", {"begin": 8.5}, 0.5),
    "rolling from": ("rolling_from", {}, 8.0),
    "contact to rolling": ("contact_to_rolling", {}, 2.0 * 0.02),
    "radius over clearance": ("largest_radius", {"bearing": "mb2"}, 0.2 / 0.75),
    "amplitude before": ("orbit_amplitude", {"bearing": "mb1", "when": "before"}, 1e-4),
    "amplitude at the end": ("orbit_amplitude", {"bearing": "mb2", "when": "end"}, 1e-4),
}
TEXTS = {
    "first_site": "RB1",
    "sites_touched": "RB1 and RB2",
    "site_of_largest_force": "RB1",
    "states_seen": "none, RB1, both",
    "outcome": "recovered",
    "bearings_that_calm": "MB1 and MB2",
}


@pytest.mark.parametrize(("name", "arguments", "value"), KNOWN.values(), ids=KNOWN)
def test_a_quantity_matches_the_synthetic_run(known_run, name, arguments, value):
    result = QUANTITIES[name][0](known_run, **arguments)
    assert result == pytest.approx(value, abs=SAMPLE if value >= 0.1 else 1e-4 * SAMPLE + 0.02 * value)


@pytest.mark.parametrize(("name", "text"), TEXTS.items())
def test_a_text_matches_the_synthetic_run(known_run, name, text):
    assert QUANTITIES[name][0](known_run) == text


def up_to(run, cycle, **attributes):
    """Return a run as if it had ended in a cycle, with other attributes."""
    is_before = run["cycle"].values < cycle
    variables, coordinates = (
        {name: Samples(samples.values[is_before], samples.attrs) for name, samples in of.items()}
        for of in (run.variables, run.coordinates)
    )
    return SignalTable(variables, coordinates, run.attrs | attributes)


def test_rolling_at_the_end_is_evaluated_for_a_retainer(known_run):
    """The known run ends free; in its ninth cycle it rolls at RB1 alone."""
    rolls, cut = QUANTITIES["rolls_at_end"][0], up_to(known_run, 8.9)
    assert [rolls(known_run), rolls(cut), rolls(cut, site="rb1"), rolls(cut, site="rb2")] == [False, True, True, False]


@pytest.mark.parametrize("name", ["site_of_largest_force", "rolls_at_end"])
def test_a_site_without_a_bearing_counts_as_a_retainer(known_run, name):
    bushes = RotorPlaces({"mb1": "", "mb2": "rb2"}, ("rb1", "rb2"))
    run = up_to(known_run, 8.9, places=bushes.to_json())
    assert QUANTITIES[name][0](run) == {"site_of_largest_force": "RB1", "rolls_at_end": True}[name]


def test_remaining_amplitude_is_the_ratio_of_end_to_before(known_run):
    before, end = (QUANTITIES["orbit_amplitude"][0](known_run, bearing="mb1", when=when) for when in ("before", "end"))
    assert QUANTITIES["amplitude_left"][0](known_run, bearing="mb1") == pytest.approx(end / before)


def test_a_number_is_converted_to_the_requested_unit(known_run):
    request = QuantityRequest("peak_force", (("site", "rb1"),), "kN")
    assert evaluate(known_run, request, QUANTITIES) == pytest.approx(3.0)


def test_a_unit_of_another_dimension_is_refused(known_run):
    with raises_naming(ValueError, "N"):
        evaluate(known_run, QuantityRequest("peak_force", (("site", "rb1"),), "mm"), QUANTITIES)


def test_an_unknown_contact_state_is_refused(known_run):
    with raises_naming(ValueError, "'RB3'", "none, RB1, RB2, both"):
        QUANTITIES["contact_share"][0](known_run, states="RB3")


def test_a_thinned_curve_keeps_its_extremes():
    x = range(50_000)
    y = [0.0] * 50_000
    y[31_234], y[7] = 5.0, -3.0
    thin = curve("force", x, y)
    assert len(thin.x) <= MOST_POINTS + 2
    assert (thin.y.max(), thin.y.min()) == (5.0, -3.0)
    assert thin.x[thin.y.argmax()] == 31_234
