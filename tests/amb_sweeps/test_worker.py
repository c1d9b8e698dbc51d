"""Points of a sweep, run one after another with the same FMUs."""

import sys

import numpy as np
import pytest

from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.results.places import places_of
from amb_cosim.results.signal_arrays import parameters, speed, thinning, turns
from amb_cosim.scenario.make_result import bare_signals, make_result
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import execute
from amb_sweeps.metrics import evaluate
from amb_sweeps.worker import Runner, Task, varied
from tests.support.messages import assert_names, raises_naming

UNTIL = 0.06
SCENARIO = load_scenario("fig4_9").changed(settle_cycles=2)
HIT = {"rotor_contact.d1.u": "60 g.m"}  # touches within `UNTIL`


def data_of(result):
    dataset = result.dataset
    return {str(name): np.array(variable.values) for name, variable in dataset.data_vars.items()}


def assert_equal(first, second):
    assert list(first) == list(second)
    for name, values in first.items():
        np.testing.assert_array_equal(values, second[name], err_msg=name)


@pytest.mark.parametrize(
    ("flavour", "coupling"),
    [
        ("native", "gauss_seidel"),
        ("native", "iterative"),
        pytest.param("python", "gauss_seidel", marks=pytest.mark.slow),
    ],
)
def test_a_reset_instance_gives_the_same_as_a_new_one(flavour, coupling):
    scenario = SCENARIO.changed(coupling=coupling)
    until = UNTIL if coupling == "gauss_seidel" else 0.01
    cases = [prepare_run(scenario, settings, until, options=RunOptions(flavour=flavour)) for settings in ({}, HIT, {})]
    fresh = [data_of(execute(case)) for case in cases]
    instances = InstancePool()
    try:
        reset = [data_of(execute(case, RunOptions(instances=instances))) for case in cases]
    finally:
        instances.close()
    for from_new, from_reset in zip(fresh, reset, strict=True):
        assert_equal(from_new, from_reset)


@pytest.mark.parametrize(
    "settings",
    [
        HIT | {"rotor_contact.rb?.offset_x": "0.2 mm"},
        {"rotor_contact.spin.free": True},
    ],
)
def test_sweeps_evaluate_what_a_complete_result_has(settings):
    """Offsets of retainers, the speed, clearances and the thinning of the record decide on values and outcomes."""
    prepared = prepare_run(SCENARIO.changed(record={"every": 20}), settings, UNTIL)
    recording = execute_plan(prepared)
    bare, complete = (
        bare_signals(prepared, recording, places_of(prepared.assembly)),
        make_result(prepared, recording).signals,
    )
    assert repr(evaluate(bare)) == repr(evaluate(complete))
    for quantity in (parameters, speed, turns, thinning):
        np.testing.assert_array_equal(quantity(bare), quantity(complete))


def test_instances_are_new_after_a_run_that_failed():
    instances = InstancePool()
    good = prepare_run(SCENARIO, {}, UNTIL)
    before = data_of(execute(good, RunOptions(instances=instances)))
    bad = prepare_run(SCENARIO, {"rotor_contact.d1.u": "9e5 g.m"}, UNTIL)
    assert execute(bad, RunOptions(instances=instances)).outcome.component == "rolac_controller"
    assert_equal(data_of(execute(good, RunOptions(instances=instances))), before)
    instances.close()


def test_a_point_has_the_key_values_of_the_summary():
    runner = Runner(Task(SCENARIO, until=UNTIL))
    point = runner.run(7, HIT)
    summary = execute(prepare_run(SCENARIO, HIT, UNTIL)).summary
    assert (point.point, point.outcome) == (7, "undecided")
    assert point.metrics["contact"] == 1.0
    for site, force in summary.peak_contact_force.items():
        assert point.metrics[f"peak_contact_force.{site}"] == force > 0.0
    averaged = summary.averaged_contact_force
    assert {site: point.metrics[f"averaged_contact_force.{site}"] for site in averaged} == averaged
    assert point.metrics["averaged_contact_force"] == max(averaged.values()) > 0.0
    assert point.metrics["peak_contact_force"] == max(summary.peak_contact_force.values())
    assert point.metrics["orbit_largest.mb1"] == summary.orbit_largest["mb1"]
    runner.close()


def test_a_point_counts_the_events_after_its_end():
    """The events are in cycles 5 and 10, or 1 and 10; the run ends in cycle 2.5."""
    runner = Runner(Task(SCENARIO, until=UNTIL))
    late = [runner.run(0, settings).metrics.get("late_events") for settings in ({}, {"step.cycle": 1})]
    runner.close()
    assert late == [2.0, 1.0]


def test_an_fmu_that_is_a_file_runs_in_the_process_of_the_sweep(monkeypatch):
    file = str(prepare_run(SCENARIO).fmus["rolac_controller"].path)
    monkeypatch.setattr("amb_cosim.cosim.run.execution.run_isolated", None)
    runner = Runner(Task(SCENARIO, until=UNTIL))
    points = [runner.run(0, {**HIT, **fmu}) for fmu in ({}, {"fmu.rolac_controller": file})]
    assert [point.outcome for point in points] == ["undecided", "undecided"]
    assert str(points[0].metrics) == str(points[1].metrics)
    runner.close()


NO_EVENTS = load_scenario("drop").changed(event=[], settle_cycles=1, end_time=0.05)
OFF = "amb_actuator.*.amplifier_off_?"
EARLY = {"label": "early", "time": 0, "set": {"amb_actuator": {"mb1.amplifier_off_x": False}}}


@pytest.mark.parametrize(
    ("scenario", "of_sweep", "of_point", "bearings"),
    [
        (NO_EVENTS, {}, {OFF: True}, {"mb1", "mb2"}),
        (NO_EVENTS, {}, {"amb_actuator.mb2.amplifier_off_y": True}, {"mb2"}),
        (NO_EVENTS, {OFF: True}, {}, {"mb1", "mb2"}),
        (NO_EVENTS, {OFF: True}, {OFF: False}, set()),
        (NO_EVENTS, {}, {}, set()),
        (NO_EVENTS, {"rotor_contact.stator_mb1.mu": 0.2}, {}, {"mb1"}),
        (NO_EVENTS.changed(event=[EARLY]), {}, {"early.amb_actuator.mb1.amplifier_off_x": True}, {"mb1"}),
    ],
)
def test_point_without_power_can_touch_the_stators(scenario, of_sweep, of_point, bearings):
    runner = Runner(Task(scenario, of_sweep))
    for settings in ({"Omega": 60.0}, of_point):  # the first has other sites
        places = places_of(runner.plan(settings).assembly)
    assert set(places.stators.values()) == bearings


def test_point_that_passes_worn_retainers_ends_on_the_stator():
    """It falls by the gap g within sqrt(2 g/9.81 m/s2) = 16 ms; with power the same setting leaves it levitated."""
    worn = {"rotor_contact.rb?.clearance": "5 mm", "rotor_contact.eb?.enabled": False}
    runner = Runner(Task(NO_EVENTS, worn))
    assert [runner.run(0, {OFF: off}).outcome for off in (False, True, False)] == ["completed", "stator", "completed"]
    runner.close()


@pytest.mark.parametrize(
    "fields",
    [
        [{"unbalance_factor": 1.0}, {"unbalance_factor": 2.0}],
        [{"gravity": 0.0}, {"gravity": 9.81}],
        [{"coupling": "gauss_seidel"}, {"coupling": "jacobi"}],
    ],
)
def test_unbalance_gravity_and_coupling_at_the_start_are_those_of_the_point(fields):
    scenario = load_scenario("compressor_levitated")
    runner = Runner(Task(scenario))
    for of_point in fields:
        plan, alone = runner.plan(of_point), prepare_run(scenario.changed(**of_point))
        assert (plan.inputs, plan.parameters, plan.warnings) == (alone.inputs, alone.parameters, alone.warnings)


def test_points_do_not_depend_on_those_before_them():
    points = [{}, HIT, {"Omega": 200.0}, HIT, {}]
    runner = Runner(Task(SCENARIO, until=UNTIL))
    first = [runner.run(0, settings).metrics for settings in points]
    again = [runner.run(0, settings).metrics for settings in reversed(points)][::-1]
    assert [str(metrics) for metrics in first] == [str(metrics) for metrics in again]
    runner.close()


def test_a_further_point_reads_no_file_and_builds_no_dataset(monkeypatch):
    runner = Runner(Task(SCENARIO, until=UNTIL))
    before = runner.run(0, HIT)

    def refuse(*_, **__):
        raise AssertionError

    for name in ("tomllib.loads", "tomllib.load", "xarray.Dataset.__init__"):
        monkeypatch.setattr(name, refuse)
    assert runner.run(0, HIT).metrics == before.metrics
    assert runner.run(1, {"rotor_contact.d1.u": "50 g.m"}).outcome == before.outcome
    runner.close()


def test_user_metrics_are_added_and_see_the_whole_record():
    task = Task(SCENARIO, until=UNTIL, metrics=(lambda result: {"samples": result.dataset.sizes["time"]},))
    assert Runner(task).run(0, {}).metrics["samples"] == 241


def broken(result):
    raise KeyError("nothing")


@pytest.mark.parametrize(
    ("metric", "is_general", "words"),
    [
        (lambda result: sys.exit(0), False, ("metric <lambda>: SystemExit: 0",)),
        (broken, False, ("metric broken: KeyError: 'nothing'",)),
        (lambda result: result.datasett, True, ("AttributeError", "datasett")),
        (lambda: {}, True, ("TypeError",)),
        (lambda result: 1.0, True, ("1.0", "dict")),
        (lambda result: {"largest": "much"}, True, ("largest", "'much'")),
        *((lambda result, name=name: {name: 1.0}, True, ("name",)) for name in ("a/b", "outcome", "", "1st", 1)),
    ],
)
def test_an_error_of_a_metric_leaves_outcome_and_values_of_the_run(metric, is_general, words):
    point = Runner(Task(SCENARIO, until=UNTIL, metrics=(metric, lambda result: {"two": 2.0}))).run(0, HIT)
    assert (point.outcome, point.reason, point.metrics["two"]) == ("undecided", "", 2.0)
    assert point.metrics["peak_contact_force"] > 0.0
    assert point.metric_error.is_general == is_general
    assert_names(point.metric_error.text, *words)


def test_a_value_that_is_not_allowed_is_an_invalid_point():
    result = Runner(Task(SCENARIO, until=UNTIL)).run(0, {"rotor_contact.rb1.clearance": "-1 mm"})
    assert result.outcome == "invalid"
    assert_names(result.reason, "rotor_contact.rb1.clearance", "-0.001 m")


@pytest.mark.slow
def test_a_record_is_kept_if_its_outcome_is_selected():
    assert Runner(Task(SCENARIO, until=UNTIL, keep=("completed",))).run(0, {}).record
    assert Runner(Task(SCENARIO, until=UNTIL, keep=("undecided",))).run(0, {}).record is None


def test_a_table_made_in_python_can_be_varied():
    table = ReceptanceTable("rig", (), (), {})
    assert varied(SCENARIO, {"receptances": table})[0].receptances is table


def test_events_fields_fmus_and_scenarios_can_be_varied():
    values = {"step.rotor_contact.d1.u": "7 g.m", "removal.cycle": 8.5, "unbalance_factor": 1.2, "Omega": 99.0}
    scenario, settings = varied(SCENARIO, values)
    step, removal = scenario.event
    assert step.set["rotor_contact"]["d1.u"] == "7 g.m"
    assert (step.cycle, removal.cycle, scenario.unbalance_factor, settings) == (5, 8.5, 1.2, {"Omega": 99.0})
    assert varied(SCENARIO, {"fmu.rolac_controller": "a.fmu"})[0].fmu == {"rolac_controller": "a.fmu"}
    assert varied(SCENARIO, {"scenario": "fig4_18"})[0].name == "fig4_18"


@pytest.mark.parametrize(
    ("scenario", "given", "facts"),
    [
        ("run_up", {"step.cycle": 3}, ("step.cycle", "run_up")),
        ("fig4_9", {"step.cycel": 3}, ("cycle",)),
        ("fig4_9", {"removal.cycle": 4}, ("relief", "disturbance")),
        ("fig4_9", {"unbalance_factor": -1.0}, ("unbalance_factor",)),
        ("fig4_9", {"scenario": "fig9_9"}, ("fig9_9",)),
    ],
)
def test_a_variable_that_the_scenario_lacks_cannot_be_varied(scenario, given, facts):
    with raises_naming(ValueError, *facts):
        varied(load_scenario(scenario), given)
