"""The free modes of a laboratory rotor as its drawing has them, beside those of an impact test."""

from pathlib import Path

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor_file import load_rotor

MEASURED = np.loadtxt(Path(__file__).parents[1] / "reference/tum_rig_modes.csv", delimiter=",", skiprows=1)


def test_untuned_free_modes_are_within_one_and_a_half_percent_of_measured():
    model = assemble(load_rotor("tum_rig"))
    frequencies, _ = free_modes(model.M[::2, ::2], model.K[::2, ::2])
    percent = 100.0 * (frequencies[:4] / (2.0 * np.pi) / MEASURED[:, 0] - 1.0)
    assert np.abs(percent).max() < 1.5
    np.testing.assert_allclose(percent, [-1.2, -0.5, 0.5, -1.1], atol=0.1)


def test_the_rotor_has_the_measured_damping_and_the_mass_of_its_bodies_and_shaft():
    rotor = load_rotor("tum_rig")
    np.testing.assert_allclose(rotor.damping.modal, MEASURED[:, 1])
    shaft = 7860.0 * np.pi / 4.0 * (0.6 * 0.008**2 + 0.102 * 0.0096**2)
    assert abs(rotor.mass - (2 * 0.85074 + 1.276499 + shaft)) < 1e-9
