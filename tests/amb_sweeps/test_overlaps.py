"""Names of a sweep that vary the same variables."""

import pytest

from amb_cosim.scenario.prepare_run import assemble_scenario
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.check import check_points
from amb_sweeps.commands import _request
from amb_sweeps.overlaps import not_replaced
from amb_sweeps.sampling import sample_plan
from amb_sweeps.worker import Task
from tests.support.messages import raises_naming

RB, ALL = "rotor_contact.rb?.mu", "rotor_contact.*.mu"
OPTIONS = {"rotor": None, "receptances": None, "set": {}, "flavour": "native"}


@pytest.mark.parametrize(
    ("vary", "sample", "facts"),
    [
        ({ALL: [0.2, 2], RB: [0.2, 2]}, "grid", (ALL, RB, "rotor_contact.rb1.mu", "rotor_contact.rb2.mu")),
        ({f"{ALL} & {RB}": [[0.2, 2], [0.2, 2]]}, "grid", (ALL, RB, "rotor_contact.rb1.mu")),
        ({ALL: "0.2:2", RB: "0.2:2"}, "lhs:4", (ALL, RB, "rotor_contact.rb1.mu")),
        ({"Omega": [240, 260], "rotor_contact.Omega": [240, 260]}, "grid", ("Omega", "rotor_contact.Omega")),
        ({"step.cycle": [5, 6], "step.time": ["0.1 s", "0.2 s"]}, "grid", ("step.cycle", "step.time")),
        ({"step.rotor_contact.d?.u": [0.02], "step.rotor_contact.d1.u": [0.01]}, "grid", ("step.rotor_contact.d1.u",)),
        ({"friction": {"low": {ALL: 0.1}}, RB: [0.2, 2]}, "grid", ("friction", RB, "rotor_contact.rb2.mu")),
    ],
)
def test_variables_that_two_names_vary_are_refused(vary, sample, facts):
    with raises_naming(ValueError, *facts):
        check_points(Task(load_scenario("fig4_9")), sample_plan(vary, sample))


def test_one_variable_at_the_start_and_from_an_event_is_varied_twice_on_purpose():
    vary = {"rotor_contact.d1.u": ["1 g.m", "2 g.m"], "step.rotor_contact.d1.u": ["20 g.m", "30 g.m"], RB: [0.1, 0.2]}
    check_points(Task(load_scenario("fig4_9")), sample_plan(vary))


def test_settings_of_a_label_are_a_list_in_order():
    vary = {"friction": {"mixed": {ALL: 0.1, "rotor_contact.rb1.mu": 0.2}}}
    check_points(Task(load_scenario("fig4_9")), sample_plan(vary))


@pytest.mark.parametrize("own", [ALL, RB])
def test_axis_of_a_ready_sweep_gives_way_to_the_same_variables(own):
    *_, merged = _request("rolling", {**OPTIONS, "vary": {own: [0.2, 2]}})
    assert {name for name in merged["vary"] if "mu" in name} == {own}
    assert "Omega" in merged["vary"]


def test_axis_of_a_ready_sweep_stays_where_another_variable_is_varied():
    scenario = load_scenario("fig4_18")
    variables = assemble_scenario(scenario).assignments()
    ready = {"Omega": "60:240:10", RB: "0.1:2:20"}
    assert not_replaced(ready, {"rotor_contact.rb1.mu": [1]}, scenario.labels, variables) == ready
    assert not_replaced(ready, {"rotor_contact.Omega": [90]}, scenario.labels, variables) == {RB: "0.1:2:20"}


@pytest.mark.parametrize(("name", "value"), [("rotor_contact.rb1.mu", 1.0), ("Omega", "90 Hz")])
def test_a_setting_that_is_varied_has_no_effect_and_is_refused(name, value):
    design = sample_plan({RB: [0.2, 2], "rotor_contact.Omega": [240, 260]})
    with raises_naming(ValueError, name, "no effect"):
        check_points(Task(load_scenario("fig4_9"), {name: value}), design)


def test_a_setting_of_more_than_is_varied_is_a_base():
    task = Task(load_scenario("fig4_9"), {ALL: 0.3})
    check_points(task, sample_plan({"rotor_contact.rb1.mu": [0.2, 2]}))


@pytest.mark.parametrize(("factor", "words"), [(1.0, ""), (1.2, ", before the factor 1.2")])
def test_description_of_an_unbalance_of_an_event_states_the_factor_of_the_scenario(factor, words):
    task = Task(load_scenario("fig4_9").changed(unbalance_factor=factor))
    *_, descriptions = check_points(task, sample_plan({"step.rotor_contact.d1.u": "5 g.m:9 g.m:2"}))
    assert descriptions["step.rotor_contact.d1.u"].endswith(f"from the step on{words}")
