"""Orbits in a summary of a thinned record."""

import numpy as np

from amb_cosim.results.orbits import notices_of_samples, orbit_largest
from tests.support.messages import assert_names

STEP = 0.02 / 100  # s: 100 steps in a turn


def test_a_thinned_record_states_how_much_of_an_orbit_its_samples_miss(synthetic):
    """A motion along a line, cos(theta + pi/10): ten samples in a turn miss its top by 1 - cos(pi/10) = 4.9 %."""
    full = synthetic(communication_step_s=STEP)
    full["rotor_contact.mb1.x"] = ("time", 1e-3 * np.cos(2.0 * np.pi * full["cycle"].values + np.pi / 10))
    full["rotor_contact.mb1.y"] = 0.0 * full["rotor_contact.mb1.x"]
    thin = full.isel(time=slice(None, None, 10))
    whole, sampled = (orbit_largest(dataset)["mb1"] for dataset in (full, thin))
    (notice,) = notices_of_samples(thin)
    assert f"{100.0 * (1.0 - sampled / whole):.1f}" == "4.9"
    assert_names(notice, "10 steps", "10 in a turn", "4.9 %")
    assert notices_of_samples(full) == []


def test_two_samples_in_a_turn_bound_no_orbit(synthetic):
    (notice,) = notices_of_samples(synthetic(communication_step_s=STEP).isel(time=slice(None, None, 50)))
    assert_names(notice, "50 steps", "2 in a turn", "by much")
