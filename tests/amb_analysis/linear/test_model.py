"""Selections, sums and copies of a linear model keep its names, units and operating point."""

import copy
import pickle

import control
import numpy as np
import pytest

from amb_analysis.linear.linearise import linearise
from amb_analysis.linear.model import FACTS
from tests.support.messages import raises_naming


@pytest.fixture(scope="module")
def machine_model():
    return linearise("compressor_levitated", "6000 rpm", components=["rotor_contact"])


ENDS = "rotor_contact.mb1.x", "rotor_contact.mb2.f_x"


@pytest.mark.parametrize(
    "select",
    [
        lambda model: model[ENDS],
        lambda model: model["rotor_contact_mb1_x", ["rotor_contact_mb2_f_x"]],
        lambda model: model[model.output_names.index(ENDS[0]), model.input_names.index(ENDS[1])],
        lambda model: model[:, ENDS[1]][ENDS[0], :],
    ],
)
def test_a_selection_of_a_model_is_one_with_names_units_and_operating_point(machine_model, select):
    chosen = select(machine_model)
    assert (chosen.output_names, chosen.input_names) == ((ENDS[0],), (ENDS[1],))
    assert (chosen.output_units, chosen.input_units) == (("m",), ("N",))
    assert chosen.operating_point == {"Omega": pytest.approx(200 * np.pi)}
    assert chosen.notes == machine_model.notes
    row, column = machine_model.output_names.index(ENDS[0]), machine_model.input_names.index(ENDS[1])
    assert chosen(100j) == pytest.approx(machine_model(100j)[row, column], rel=1e-9)


@pytest.mark.parametrize(
    ("change", "factor"),
    [
        (lambda model: -model, -1.0),
        (lambda model: 2 * model, 2.0),
        (lambda model: model / np.float64(4.0), 0.25),
        (lambda model: model + model, 2.0),
        (lambda model: model - 3 * model, -2.0),
        (lambda model: pickle.loads(pickle.dumps(model)), 1.0),
        (copy.deepcopy, 1.0),
    ],
)
def test_multiples_sums_and_copies_of_a_model_keep_its_facts(machine_model, change, factor):
    changed = change(machine_model)
    for fact in FACTS:
        assert getattr(changed, fact) == getattr(machine_model, fact)
    np.testing.assert_allclose(changed(100j), factor * machine_model(100j), rtol=1e-9, atol=1e-15)


def test_a_sampled_model_keeps_units_and_its_response_below_the_sampling_frequency(machine_model):
    one = machine_model[ENDS]
    sampled = one.sample(1e-5, "tustin")
    assert (sampled.dt, sampled.output_units, sampled.operating_point) == (1e-5, ("m",), one.operating_point)
    assert sampled(np.exp(100j * 1e-5)) == pytest.approx(one(100j), rel=1e-5)


def test_a_sum_of_models_with_other_signals_has_no_units(machine_model):
    other = machine_model["rotor_contact.mb2.x", "rotor_contact.mb2.f_x"]
    assert type(machine_model[ENDS] + other) is control.StateSpace


@pytest.mark.parametrize(
    ("key", "fact"),
    [(0, "0"), (("nosuch", 0), "'nosuch'"), ((0, "nosuch"), "'nosuch'"), ((99, 0), "99"), ((0, 1.5), "1.5")],
)
def test_a_selection_that_the_model_lacks_is_refused(machine_model, key, fact):
    with raises_naming(ValueError, fact):
        machine_model[key]
