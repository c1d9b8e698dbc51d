"""Warnings of a run, from outputs and logs of the FMUs to sentences, and that of its coupling."""

import json
from dataclasses import asdict
from functools import partial

import numpy as np
import pytest

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.cosim.record.warnings import WarningRecord, of_component, sentences, share_of_time
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.power import with_power
from amb_cosim.scenario.coupling import coupling_warning
from tests.support.messages import assert_names

TIMES = np.arange(-2.0, 8.0)
TEMPLATE = "the current is cut to {limit} A"
PORTS = {
    name: Port(f"{name}.cut", "Boolean", "output", k, warning=TEMPLATE.replace("limit", f"{name}.limit"))
    for k, name in enumerate(("mb1", "mb2"))
}
ALL_PORTS = (*PORTS.values(), Port("mb1.limit", "Real", "output", 2), Port("mb2.limit", "Real", "input", 3))


def warning_records(log=(), values=(), **samples):
    recorded = {f"{name}.cut": np.isin(TIMES, true).astype(float) for name, true in samples.items()} | dict(values)
    return of_component("actuator", {port.name: port for port in ALL_PORTS}, log, -2.0, TIMES, recorded)


def logged(name, time):
    where = "initialisation" if time is None else f"at t = {time} s"
    return f"{where}: {name}.cut: the current is cut to 10 A"


def test_a_flag_that_was_never_true_gives_no_warning():
    assert warning_records(mb1=[], mb2=[]) == []


def test_a_warning_lasts_from_its_first_to_its_last_sample():
    (warned,) = warning_records([logged("mb1", 1.25)], mb1=[2.0, 3.0, 6.0], mb2=[])
    assert (warned.component, warned.variable) == ("actuator", "mb1.cut")
    assert warned.sentence == "the current is cut to 10 A"
    assert (warned.first, warned.last, warned.share) == (1.25, 6.0, 3 / 7)


def test_a_warning_of_every_tenth_step_has_a_tenth_of_the_time():
    """Of 500 steps of 0.1 ms from time 0, each tenth ends with a warning; the sample at time 0 ends an earlier step."""
    times = 1e-4 * np.arange(-20, 501)
    true = np.arange(-20, 501) % 10 == 0
    (warned,) = of_component("actuator", {"mb1.cut": PORTS["mb1"]}, [], -2e-3, times, {"mb1.cut": true * 1.0})
    assert warned.share == pytest.approx(0.1, rel=1e-12)


def test_steps_count_by_their_duration():
    """The last sample of a thinned record may follow sooner than the others: 1 s of 2.5 s."""
    times, true = np.array([0.0, 1.0, 2.0, 2.5]), np.array([True, True, False, False])
    assert share_of_time(times, true) == pytest.approx(0.4)
    assert share_of_time(times, ~true) == pytest.approx(0.6)


def test_without_a_step_after_time_0_a_warning_has_no_share():
    (warned,) = of_component("actuator", {"mb1.cut": PORTS["mb1"]}, [], 0.0, np.zeros(1), {"mb1.cut": np.ones(1)})
    assert (warned.first, warned.last, warned.share) == (0.0, 0.0, None)
    assert sentences([warned]) == ["the current is cut to mb1.limit A (mb1.cut; at 0 s)"]


def test_a_demand_at_its_limit_counts_only_with_power_and_after_time_0():
    """Of ten steps from time 0, the demand is limited in the first three and without power from the third on."""
    n = np.arange(-1, 11)
    limited, off = (n <= 3).astype(float), (n >= 3).astype(float)
    variables = {"rolac_controller.current_limited": limited} | {
        f"amb_actuator.mb1.amplifier_off_{axis}": off for axis in "xy"
    }
    places = RotorPlaces({"mb1": ""}, (), magnetic=("mb1",))
    signals = SignalTable(
        {name: Samples(values, {}) for name, values in variables.items()},
        {"time": Samples(0.1 * n, {}), "cycle": Samples(0.1 * n, {})},
        {"places": json.dumps(asdict(places))},
    )
    (kept,) = with_power([WarningRecord("rolac_controller", "current_limited", "", "cut", -0.1, 0.3, 0.3)], signals)
    assert kept.share == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("true", "expected"), [([2.0, 3.0, 6.0], "8 to 13"), ([2.0], "9 to 10"), ([], "10")], ids=["several", "one", "none"]
)
def test_a_recorded_value_in_a_warning_has_its_range_while_it_was_true(true, expected):
    """At the time of the log it was 10; before and after, when nothing was cut, it was 99."""
    limits = np.select([TIMES == 2.0, TIMES == 3.0, TIMES == 6.0], [9.0, 8.0, 13.0], 99.0)
    (warned,) = warning_records([logged("mb1", 1.25)], {"mb1.limit": limits}, mb1=true)
    assert warned.sentence == f"the current is cut to {expected} A"


def test_an_input_in_a_warning_has_the_value_at_its_time():
    """A sample has the input of the next step, which may no longer be true."""
    limits = np.where(TIMES < 2.0, 10.0, 99.0)
    (warned,) = warning_records([logged("mb2", 1.25)], {"mb2.limit": limits}, mb2=[2.0])
    assert warned.sentence == "the current is cut to 10 A"


def test_an_unrecorded_warning_is_taken_from_the_log():
    (warned,) = warning_records([logged("mb1", 1.25)])
    assert (warned.first, warned.last, warned.share) == (1.25, None, None)
    assert sentences([warned]) == ["the current is cut to 10 A (mb1.cut; first at 1.25 s)"]


def test_a_warning_without_a_log_is_taken_from_the_samples():
    (warned,) = warning_records(mb1=[2.0, 3.0])
    assert (warned.sentence, warned.first, warned.last) == ("the current is cut to mb1.limit A", 2.0, 3.0)


@pytest.mark.parametrize(
    ("log", "samples", "expected"),
    [
        ([None], [], "only before time 0, during settling"),
        ([-1.5], [], "only before time 0, during settling"),
        ([-1.5], [1.0], "from before time 0 to 1 s, 14.3 % of the time"),
        ([0.5], [1.0], "from 0.5 s to 1 s, 14.3 % of the time"),
        ([1.0], [1.0], "at 1 s, 14.3 % of the time"),
    ],
)
def test_time_span_of_a_warning_includes_settling(log, samples, expected):
    warned = warning_records([logged("mb1", time) for time in log], mb1=samples)
    assert sentences(warned) == [f"the current is cut to 10 A (mb1.cut; {expected})"]


def test_equal_warnings_of_several_variables_are_one_line():
    warned = warning_records([logged("mb1", 1.0), logged("mb2", 3.0)], mb1=[1.0], mb2=[3.0, 4.0])
    assert len(warned) == 2
    expected = "the current is cut to 10 A (mb1.cut, mb2.cut; from 1 s to 4 s, up to 28.6 % of the time)"
    assert sentences(warned) == [expected]


def test_an_undeclared_warning_of_an_fmu_is_passed_on_once():
    warned = warning_records(["the table is old", "the table is old"])
    assert sentences(warned) == ["the table is old (actuator)"]


SYSTEM = """
[[component]]
name = "magnets"
fmu = "amb_actuator"

[[component]]
name = "spare"
fmu = "amb_actuator"

[parameters.spare]
"mb2.b_sat_x" = 0.5

[experiment]
communication_step = "1 ms"
start_time = "-10 ms"
stop_time = "20 ms"

[experiment.record]
variables = [RECORDED]

[[experiment.event]]
time = "5 ms"
set = { "magnets.mb1.i_x" = 7.0 }

[[experiment.event]]
time = "9 ms"
set = { "magnets.mb1.i_x" = 0.0 }
"""


def run_magnets(path: str, flavour: str) -> list:
    import dataclasses

    import amb_cosim
    from amb_cosim.cosim.record.warnings import warnings_of

    runs = [warnings_of(amb_cosim.simulate(path, flavour=flavour, loop=loop).signals) for loop in ("compiled", "plain")]
    assert runs[0] == runs[1]
    return [dataclasses.astuple(warned) for warned in runs[0]]


@pytest.mark.parametrize("flavour", ["native", "python"])
@pytest.mark.parametrize("recorded", ["*", "*.f_x"])
def test_a_run_has_the_warnings_of_each_component(tmp_path, run_python, flavour, recorded):
    path = tmp_path / "magnets.toml"
    path.write_text(SYSTEM.replace("RECORDED", f'"{recorded}"'), encoding="utf-8")
    run = run_magnets if flavour == "native" else partial(run_python, run_magnets)
    values = [WarningRecord(*warned) for warned in run(path=str(path), flavour=flavour)]
    by_name = {f"{warned.component}.{warned.variable}": warned for warned in values}
    assert sorted(by_name) == ["magnets.mb1.clipped_x", "magnets.mb1.saturated_x", "spare.mb2.saturated_x"]
    clipped, saturated = by_name["magnets.mb1.clipped_x"], by_name["spare.mb2.saturated_x"]
    assert_names(clipped.sentence, "demanded current", "limited", "10 A")
    assert clipped.first == pytest.approx(6e-3), "the end of the step that began with the command"
    assert saturated.sentence.startswith("a coil pair saturates at 0.5 T")
    assert saturated.first == pytest.approx(-10e-3), "from the initialisation on"
    if recorded == "*":
        assert clipped.last == pytest.approx(9e-3)
        assert clipped.share == pytest.approx(4 / 20)
        assert saturated.share == 1.0
    else:
        assert (clipped.last, clipped.share) == (None, None)


def beside_another_user_of_fmpy(path: str) -> list:
    import gc

    import fmpy

    import amb_cosim
    from amb_cosim.cosim.fmu.fmus import ensure_built
    from amb_cosim.cosim.record.warnings import warnings_of

    counts = [len(warnings_of(amb_cosim.simulate(path).signals))]
    fmpy.simulate_fmu(str(ensure_built("amb_actuator").path), stop_time=0.002, logger=lambda *message: None)
    gc.collect()
    return [*counts, len(warnings_of(amb_cosim.simulate(path).signals))]


def test_a_run_receives_messages_after_another_logger_of_fmpy(run_python, tmp_path):
    """The other logger no longer exists; an FMU that called it would crash."""
    path = tmp_path / "magnets.toml"
    path.write_text(SYSTEM.replace("RECORDED", '"*.f_x"'), encoding="utf-8")
    assert run_python(beside_another_user_of_fmpy, path=str(path)) == [3, 3]


@pytest.mark.parametrize(
    ("sample_time", "allowed", "step", "facts"),
    [
        (250e-6, 50e-6, 51e-6, ("50 µs", "controller's sample time")),
        (100e-6, 20e-6, 25e-6, ("20 µs", "controller's sample time")),
        (None, 50e-6, 51e-6, ("50 µs", "250 µs")),
    ],
)
def test_a_jacobi_step_beyond_a_fifth_of_the_sample_time_warns(sample_time, allowed, step, facts):
    assert coupling_warning("jacobi", allowed, 0.0, sample_time) is None
    assert coupling_warning("gauss_seidel", step, 0.0, sample_time) is None
    assert_names(coupling_warning("jacobi", step, 0.0, sample_time), *facts)
