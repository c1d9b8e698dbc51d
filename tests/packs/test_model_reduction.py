"""The study of the rig's reduced models: bounds of the meshes, errors, the thesis's numbers beside ours."""

import numpy as np
import pytest

from amb_cosim import studies
from bath_thesis.printed import table_of
from bath_thesis.studies.reduced_models import ModelReduction
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor_file import load_rotor


@pytest.fixture(scope="module")
def result() -> ModelReduction:
    return studies.reduction(up_to="200 rad/s")


def test_printed_errors_follow_from_the_printed_frequencies():
    """Table 3.4 against the 23 nodes of Table 3.1 at 90 rad/s has about the 20.44 % of section 3.4."""
    finest = np.array(table_of("frequencies")["23_node"]["consistent"]["90"])
    coarse = np.array(table_of("reduction")["6_node"]["diagonal"]["90"])
    mean = 100.0 * np.mean(np.abs(coarse / finest - 1.0))
    assert mean == pytest.approx(table_of("reduction")["mean_error"]["6_node"]["diagonal"], abs=0.3)


@pytest.mark.slow
def test_condensed_model_is_closer_to_the_full_one_than_the_coarse_mesh(result):
    full, condensed, coarse = (result.models[name] for name in ("13_node", "condensed", "6_node"))
    assert (full.coordinates, condensed.coordinates, coarse.coordinates) == (52, 12, 24)
    errors = [np.abs(model.displacement / full.displacement - 1.0).max() for model in (condensed, coarse)]
    assert errors[0] < 0.1 * errors[1]
    np.testing.assert_allclose(condensed.frequencies, full.frequencies, rtol=2e-3)
    np.testing.assert_allclose(condensed.critical_speeds, full.critical_speeds, rtol=1e-3)


@pytest.mark.slow
def test_error_is_small_with_consistent_mass_and_largest_if_coarsest(result):
    errors = [result.mean_errors[model]["consistent"].computed for model in ("19_node", "13_node", "6_node")]
    assert errors == sorted(errors)
    assert errors[-1] < 0.01


def test_every_mesh_has_the_mass_and_lumping_raises_the_inertia(result):
    body = rigid_body(load_rotor())
    consistent = [row["consistent"] for model, row in result.mean_errors.items() if model != "condensed"]
    lumped = [row["diagonal"] for model, row in result.mean_errors.items() if model != "condensed"]
    for row in (*consistent, *lumped):
        assert row.mass == pytest.approx(body.mass, rel=1e-9)
    assert [row.diametral_inertia for row in consistent] == pytest.approx([body.diametral_inertia] * 4, rel=1e-9)
    inertias = [row.diametral_inertia for row in lumped]  # 23, 19, 13, 6 nodes
    assert inertias == sorted(inertias)
    assert body.diametral_inertia < inertias[0]
