"""The thesis's own numbers, Tables 2.1, 3.1 and 3.4."""

import json
from pathlib import Path

import numpy as np
import pytest

from rotor_analysis.tables import frequency_tables
from rotor_contact.assembly import assemble
from rotor_contact.rotor_file import load_rotor

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def computed():
    return frequency_tables()


@pytest.mark.parametrize("mass", ["consistent", "diagonal"])
@pytest.mark.parametrize("speed", ["90", "145"])
def test_frequencies_of_the_13_node_model_are_those_of_table_3_1(computed, mass, speed):
    printed = THESIS["table_3_1"]["13_node"][mass][speed]
    np.testing.assert_allclose(computed["table_3_1"]["13_node"][mass][speed], printed, rtol=6e-3)


@pytest.mark.parametrize("row", ["fem_13", "condensed"])
def test_full_and_condensed_frequencies_are_those_of_table_3_4(computed, row):
    printed = THESIS["table_3_4"]["fem_13_diagonal" if row == "fem_13" else row]
    np.testing.assert_allclose(computed["table_3_4"]["90"][row], printed, rtol=6e-3)


@pytest.mark.parametrize("speed", ["90", "120", "145"])
def test_condensation_costs_no_more_accuracy_than_the_thesis_says(computed, speed):
    table = computed["table_3_4"][speed]
    error = np.array(table["condensed"]) / np.array(table["fem_13"]) - 1.0
    assert np.max(np.abs(error)) < 1.2e-3
    assert np.max(np.abs(error)) > 1e-5  # a condensed model that is the full one would say nothing


def test_mass_of_the_rig_is_96_kg_in_the_description_and_in_both_mass_matrices():
    rotor = load_rotor()
    assert rotor.mass == pytest.approx(96.0, abs=0.1)
    for kind in ("consistent", "diagonal"):
        full = assemble(rotor, kind)
        along_x = np.zeros(full.size)
        along_x[0::4] = 1.0
        assert along_x @ full.M @ along_x == pytest.approx(rotor.mass, rel=1e-12)
