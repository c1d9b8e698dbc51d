"""Share of the contact force's power beyond the band of the reduction, for signals with a closed form."""

import json

import numpy as np
import pytest

from amb_cosim.results.contact_spectrum import share_beyond_reduction, warnings_beyond_reduction
from amb_cosim.results.summary import summarise

VALID_TO = 1000.0  # rad/s; the sampling of 5000 per second shows up to 15708 rad/s


@pytest.fixture
def pressed(synthetic):
    """A run with a prescribed force on RB1, of a rotor that is accurate up to VALID_TO."""

    def make(force, valid_to=VALID_TO):
        dataset = synthetic()
        places = json.loads(dataset.attrs["places"]) | {"valid_to": valid_to}
        dataset = dataset.assign_attrs(places=json.dumps(places))
        dataset["rotor_contact.rb1.f_n"] = "time", force(dataset["time"].values)
        dataset["rotor_contact.rb2.f_n"] = "time", np.zeros(dataset.sizes["time"])
        return dataset

    return make


def test_contact_in_the_last_moment_of_a_run_counts(pressed):
    dataset = pressed(lambda t: np.where(t > t[-1] - 0.01, 100.0 + 50.0 * np.cos(3000.0 * t), 0.0))
    assert 0.01 < share_beyond_reduction(dataset)["rb1"] < 0.5
    assert share_beyond_reduction(pressed(lambda t: 1.0 * (t == t[0])))["rb1"] is None, "a window begins with zero"


def test_power_is_split_between_two_harmonics_at_the_limit(pressed):
    # mean squares: 300^2, 80^2 / 2, 60^2 / 2
    dataset = pressed(lambda t: 300.0 + 80.0 * np.cos(500.0 * t) + 60.0 * np.cos(3000.0 * t))
    result = share_beyond_reduction(dataset)
    assert result["rb1"] == pytest.approx(1800.0 / (90000.0 + 3200.0 + 1800.0), rel=0.01)
    assert result["rb2"] is None, "no force, no share"


def test_a_force_above_the_frequency_limit_warns_with_site_and_limit(pressed):
    (sentence,) = summarise(pressed(lambda t: 100.0 + 100.0 * np.cos(3000.0 * t))).warnings
    assert sentence.startswith("much of the contact force's power is above 159.2 Hz")
    assert "RB1 33.3 % (allowed: 10 %)" in sentence


def test_without_a_frequency_limit_no_share_is_reported(pressed):
    dataset = pressed(lambda t: 100.0 + 100.0 * np.cos(3000.0 * t), None)
    assert share_beyond_reduction(dataset) == {"rb1": None, "rb2": None}
    assert warnings_beyond_reduction(dataset) == []
