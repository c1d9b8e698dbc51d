"""The thesis's own numbers, Tables 2.1, 3.1 to 3.4."""

import json
from pathlib import Path

import numpy as np
import pytest

from bath_thesis.studies.frequency_tables import frequency_tables
from rotor_analysis.rotor_file import load_rotor

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def computed():
    return frequency_tables(load_rotor())


@pytest.mark.parametrize("mass", ["consistent", "diagonal"])
@pytest.mark.parametrize("speed", ["90", "145"])
def test_frequencies_of_the_13_node_model_match_table_3_1(computed, mass, speed):
    tabulated = THESIS["table_3_1"]["13_node"][mass][speed]
    np.testing.assert_allclose(computed.by_mesh["13_node"][mass][speed], tabulated, rtol=6e-3)


@pytest.mark.parametrize("row", ["fem_13", "condensed"])
def test_full_and_condensed_frequencies_match_table_3_4(computed, row):
    tabulated = THESIS["table_3_4"]["fem_13_diagonal" if row == "fem_13" else row]
    np.testing.assert_allclose(computed.condensed["90"][row], tabulated, rtol=6e-3)


@pytest.mark.parametrize("mass", ["consistent", "diagonal"])
def test_frequencies_on_23_nodes_differ_by_the_mass_of_the_thesis_model(computed, mass):
    """The thesis's 23-node rotor is 2.6 % heavier than its 13-node rotor: rigid frequencies 1.3 % lower."""
    tabulated = np.array(THESIS["table_3_1"]["23_node"][mass]["90"])
    above = np.array(computed.by_mesh["23_node"][mass]["90"]) / tabulated - 1.0
    assert np.all((above > 0.0) & (above < 0.015))
    np.testing.assert_allclose(np.mean(above[:4]), 0.013, atol=0.002)
    np.testing.assert_allclose(computed.deviation_from_thesis["23_node"][mass]["90"], 100.0 * above, rtol=1e-9)


def test_diagonal_mass_needs_more_nodes_than_consistent_mass(computed):
    table = computed.by_mesh
    assert list(table) == ["23_node", "19_node", "13_node", "6_node"]
    exact = np.array(table["23_node"]["consistent"]["145"])
    errors = {
        mass: [np.max(np.abs(np.array(rows[mass]["145"]) / exact - 1.0)) for rows in table.values()]
        for mass in ("consistent", "diagonal")
    }
    assert np.all(np.diff(errors["diagonal"]) > 0.0)
    assert errors["diagonal"][-1] > 0.05
    assert errors["consistent"][-1] < 1e-3
