"""From a scenario to numbers: values, rates, and the communication points of events."""

import math
import os
import signal
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from interfaces import interface

from amb_cosim.commands.options import parse_settings
from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.processes.interruption import deferred
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from amb_cosim.model_constants.plant_data import plant
from amb_cosim.scenario.plan import scenario_plan
from amb_cosim.scenario.scenario import make_scenario
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names, raises_naming

INTERFACES = {
    "sampler": interface(
        Port("sample_time", "Real", "parameter", 0, "s", start=250e-6, minimum=1e-6),
        Port("k_x", "Real", "parameter", 1, "N/m", start=1.0),
        Port("k_y", "Real", "parameter", 2, "N/m", start=1.0),
        Port("Omega", "Real", "input", 3, unit="rad/s", minimum=0.0, maximum=500.0),
        Port("x", "Real", "input", 4, unit="m"),
        Port("i", "Real", "output", 5, unit="A"),
        Port("gain", "Real", "parameter", 6, start=1.0, variability="tunable"),
    ),
    "rotor": interface(
        Port("Omega", "Real", "input", 0, unit="rad/s", minimum=-1e4, maximum=1e4),
        Port("d1.u", "Real", "input", 1, unit="kg.m", minimum=0.0, maximum=0.1),
        Port("d2.u", "Real", "input", 2, unit="kg.m", start=0.003),
        Port("x", "Real", "output", 3, unit="m"),
        Port("Omega_dot", "Real", "input", 4, unit="rad/s2"),
    ),
}
SYSTEM = System(
    "pair",
    "d",
    (Component("sampler", "a"), Component("rotor", "b")),
    (Connection("rotor.x", "sampler.x"),),
    (Signal("Omega", ("rotor.Omega", "sampler.Omega")), Signal("Omega_dot", ("rotor.Omega_dot",))),
)
SCENARIO = """
description = "d"
Omega = "100 rad/s"
settle_cycles = 2
end_cycle = 10
unbalance_factor = 2
inputs.rotor."d1.u" = "5 g.m"
[[event]]
label = "step"
role = "disturbance"
cycle = 5
set.rotor."d1.u" = "10 g.m"
[[event]]
time = "0.4 s"
set.rotor."d2.u" = "1 g.m"
"""
NO_EVENTS = SCENARIO.split("[[event]]")[0]
PERIOD = 2.0 * math.pi / 100.0
H = 250e-6


def plan(settings=None, until=None, scenario=SCENARIO, system=SYSTEM, extra="", fmus=None, **interfaces):
    assembly = Assembly(system, fmus or {}, INTERFACES | interfaces)
    return scenario_plan(make_scenario(tomllib.loads(extra + scenario), "mine"), assembly, settings, until)


def profile(p):
    return next((ramp.points for ramp in p.ramps if ramp.variable == "Omega"), ())


def test_moments_are_the_nearest_communication_points():
    p = plan()
    assert p.last == round(10 * PERIOD / H)
    assert p.marks == {"step": round(5 * PERIOD / H)}
    assert abs(p.marks["step"] * H - 5 * PERIOD) <= H / 2
    assert -p.first == math.ceil(2 * PERIOD / H)
    assert [n for n, _, _ in p.events] == [p.marks["step"], 1600]


def test_loss_factor_that_a_model_approximates_is_a_warning_of_the_run():
    fmus = {"rotor": SimpleNamespace(layout={"loss_factor": 0.015}), "sampler": SimpleNamespace(layout=None)}
    (sentence,) = plan(fmus=fmus).warnings
    assert_names(sentence, "rotor", "loss_factor = 0.015", "viscous")
    fmus["rotor"].layout["loss_factor"] = 0.0
    assert plan(fmus=fmus).warnings == ()


def test_implausible_sizes_of_the_rotor_are_warnings_of_the_run():
    """The plant has them in its layout, so that a run need not read the rotor."""
    shaft = Shaft((0.0, 150.0, 300.0), (0.5,), youngs_modulus=2e11, density=7850.0, poissons_ratio=0.3)
    long = Rotor("long", shaft, bearings=(Bearing("left", 1), Bearing("right", 3)))
    model, _ = plant(long)
    fmus = {"rotor": SimpleNamespace(layout=model.layout), "sampler": SimpleNamespace(layout=None)}
    warnings = plan(fmus=fmus).warnings
    assert warnings == implausible_sizes(long)
    assert_names(warnings[0], "rotor long", "300 m", "<= 40 m", "mm")
    assert model.layout["mass"] == pytest.approx(300.0 * math.pi / 4.0 * 0.5**2 * 7850.0)


def test_unbalance_in_a_mistaken_unit_is_a_warning_of_the_run():
    """The event doubles 10 g m: 20 g m of 3 kg is 6.67 mm, and 6.67 mm at 100 rad/s 667 mm/s."""

    def warnings(mass, extra=""):
        fmus = {"rotor": SimpleNamespace(layout={"mass": mass}), "sampler": SimpleNamespace(layout=None)}
        return plan(scenario=SCENARIO + extra, fmus=fmus).warnings

    (sentence,) = warnings(3.0)
    assert_names(sentence, "rotor.d1.u = 0.02 kg m", "3 kg", "954.9 rpm", "6.67 mm", "G 666.7", "<= G 630")
    assert warnings(3.2) == ()
    (faster,) = warnings(6.0, '[[speed]]\ncycle = 6\nOmega = "200 rad/s"\n')
    assert_names(faster, "1910 rpm", "G 666.7")


@pytest.mark.parametrize("steps", [1, 3, 1000, 7 * 10**8])
@pytest.mark.parametrize("h", [1e-4, 5e-5, 4.9999999999999996e-05, 2.5e-4, 1 / 3 * 1e-3, 1e-6])
def test_times_of_whole_and_half_steps_keep_their_point(steps, h):
    for error in (-4e-16, 0.0, 4e-16):
        for count in (steps, -steps, steps + 0.5):
            assert in_steps(count * h * (1.0 + error), h) == count
    assert in_steps((steps + 1e-3) * h, h) == pytest.approx(steps + 1e-3, rel=1e-12)


def test_the_factor_scales_only_values_that_the_scenario_sets():
    p = plan()
    assert p.inputs["rotor.d1.u"] == pytest.approx(10e-3)
    assert p.events[0][1:] == ("rotor.d1.u", pytest.approx(20e-3))
    assert p.inputs["rotor.d2.u"] == 0.003, "an input that only an event sets starts as the FMU does"
    assert plan({"rotor.d1.u": "5 g.m"}).inputs["rotor.d1.u"] == pytest.approx(5e-3)


def test_scenario_and_settings_override_parameters_of_the_system():
    system = replace(SYSTEM, parameters={"sampler": {"k_?": 5.0}})
    values = {"scenario": SCENARIO + "[parameters.sampler]\nk_y = 6\n", "system": system}
    p = plan(**values)
    assert (p.parameters["sampler"]["k_x"], p.parameters["sampler"]["k_y"]) == (5.0, 6.0)
    p = plan({"sampler.k_y": "7"}, **values)
    assert (p.parameters["sampler"]["k_x"], p.parameters["sampler"]["k_y"]) == (5.0, 7.0)


def test_an_error_in_a_setting_does_not_name_the_scenario():
    with raises_naming(ValueError, "no component 'rotr'") as error:
        plan({"rotr.d1.u": 1.0})
    assert "mine" not in str(error.value)


def test_a_new_speed_moves_the_cycles_and_reaches_all_targets():
    for name in ("Omega", "rotor.Omega", "sampler.Omega"):
        p = plan({name: 200})
        assert p.period == pytest.approx(PERIOD / 2)
        assert p.inputs["Omega"] == 200.0
        assert p.marks["step"] == round(5 * PERIOD / 2 / H)


def test_cycles_of_a_rotor_at_rest_last_10_ms():
    """It may turn later, and stop again."""
    points = '[[speed]]\ncycle = 6\nOmega = "50 rad/s"\n[[speed]]\ntime = "0.1 s"\nOmega = 0\n'
    p = changing(points, scenario=SCENARIO.replace('"100 rad/s"', "0"))
    assert (p.inputs["Omega"], p.period, p.marks["step"]) == (0.0, 0.01, round(5 * 0.01 / H))
    assert profile(p) == ((0, 0.0), (round(0.06 / H), 50.0), (round(0.1 / H), 0.0))


RUN_UP = """
[[speed]]
time = "0.2 s"
Omega = "100 rad/s"
[[speed]]
cycle = 20
Omega = "300 rad/s"
"""


def changing(points=RUN_UP, settings=None, system=SYSTEM, scenario=SCENARIO):
    return plan(settings, scenario=scenario + points, system=system)


def test_points_of_a_speed_profile_are_communication_points():
    p = changing()
    assert profile(p) == ((0, 100.0), (800, 100.0), (round(20 * PERIOD / H), 300.0))
    assert p.inputs["Omega_dot"] == 0.0
    assert profile(plan()) == ()


def test_a_new_initial_speed_moves_the_points_stated_in_cycles():
    p = changing(settings={"Omega": "50 rad/s"})
    assert profile(p) == ((0, 50.0), (800, 100.0), (round(40 * PERIOD / H), 300.0))


OF_SPEED = '[[event]]\ncycle = 7\nset.sampler.Omega = "50 rad/s"\n'


def test_an_event_may_set_a_speed_without_a_profile():
    assert plan().inputs["Omega"] == 100.0
    assert ("Omega", 50.0) in [e[1:] for e in plan(scenario=SCENARIO + OF_SPEED).events]


def test_the_end_may_be_a_time():
    assert plan(scenario=SCENARIO.replace("end_cycle = 10", "end_time = '300 ms'")).last == 1200


def test_sample_time_sets_the_rate_and_settling_fits_it():
    p = plan({"sampler.sample_time": "1.75 ms"})
    assert [c.every for c in p.system.components] == [7, 1]
    assert p.first % 7 == 0
    assert p.first <= -2 * PERIOD / H


ANY_STEP = replace(INTERFACES["sampler"], takes_any_step=True)


EVEN = [("250 us", ""), ("1.75 ms", ""), ("1.7500000001 ms", "")]
UNEVEN = [("300 us", "0.0003 s"), ("1.750001 ms", "0.001750001 s")]


@pytest.mark.parametrize(("sample_time", "stated"), EVEN + UNEVEN)
def test_samples_between_communication_points_cause_a_warning(sample_time, stated):
    """Every 300 us in steps of 250 us: the second instant is in the step from 250 us, 50 us before it.

    Every 1.750001 ms it is as early after some 250,000 samples. Both drift from the start of a run, which is then not
    chosen for samples at cycle 0. An FMU of any step size is called in every step.
    """
    prepared = plan({"sampler.sample_time": sample_time}, sampler=ANY_STEP)
    assert [c.every for c in prepared.system.components] == [1, 1]
    assert prepared.first <= -2 * PERIOD / H
    warnings = [text for text in prepared.warnings if "unevenly" in text]
    assert len(warnings) == bool(stated)
    for text in warnings:
        assert_names(text, "sampler", "0.00025 s early", f"sample_time = {stated}")
    if sample_time.startswith("1.75"):
        assert (prepared.first % 7 == 0) is not bool(stated)


def test_a_pattern_sets_all_that_match():
    p = plan({"sampler.k_?": 5, "rotor.*.u": "1 g.m"})
    assert p.parameters["sampler"] == {"k_x": 5.0, "k_y": 5.0}
    assert (p.inputs["rotor.d1.u"], p.inputs["rotor.d2.u"]) == (1e-3, 1e-3)


def test_end_is_a_whole_number_of_steps():
    for until in (0.1, "0.1", "100 ms", "100000 us"):
        prepared = plan(until=until, scenario=NO_EVENTS)
        assert (prepared.last, prepared.notices) == (400, ())
    rounded = plan(until=0.1001, scenario=NO_EVENTS)
    assert rounded.last == 400
    (notice,) = rounded.notices
    assert_names(notice, "until", "0.1001 s", "0.00025 s", "0.1 s")


def test_an_event_after_the_end_of_the_run_is_noticed():
    """Cycle 5 is at 0.314 s."""
    assert plan().notices == plan(until=0.5).notices == ()
    (notice,) = plan(scenario=SCENARIO.replace("cycle = 5", "cycle = 50")).notices
    assert_names(notice, "event step", "cycle 50", "cycle 10", "3.14159 s", "0.628319 s")
    unnamed, named = plan(until=0.3).notices
    assert_names(unnamed, "event that sets rotor", "0.4 s", "0.3 s")
    assert_names(named, "event step", "cycle 5", "0.314159 s", "0.3 s")


def test_an_event_sets_a_tunable_parameter_of_the_component():
    prepared = plan({"sampler.gain": 3.0}, extra="event = [{ time = 0.1, set.sampler.gain = 2 }]\n", scenario=NO_EVENTS)
    assert prepared.events == ((400, "sampler.gain", 2.0),)
    assert (prepared.inputs["sampler.gain"], prepared.parameters["sampler"]["gain"]) == (3.0, 3.0)
    wiring = Assembly(prepared.system, {}, INTERFACES).wiring(prepared.inputs)
    assert wiring.inputs["sampler"][-1] == "gain"
    assert wiring.names[wiring.sources[0][-1]] == "sampler.gain"


def test_recorded_variables_follow_the_patterns():
    assert plan().recorded == ("Omega", "Omega_dot", "rotor.d1.u", "rotor.d2.u", "sampler.i", "rotor.x")
    assert plan(extra='record.variables = ["rotor.*"]\n').recorded == ("rotor.d1.u", "rotor.d2.u", "rotor.x")


STOP = """
stop = [
    { variable = "sampler.i", above = "2 kA", hold_cycles = 2, from_time = "50 ms" },
    { variable = "Omega", below = "10 Hz" },
]
"""


def test_a_condition_becomes_numbers_in_the_units_of_its_signal():
    h, period = 250e-6, 2.0 * math.pi / 100.0
    current, speed = plan(extra=STOP).stops
    assert current[:5] == ("sampler.i", True, 2000.0, 200, round(2 * period / h))
    assert current.text == f"sampler.i above 2000 A for {round(2 * period / h) * h:.9g} s"
    assert speed[:5] == ("Omega", False, pytest.approx(20 * math.pi, rel=1e-15), 0, 0)
    assert speed.text == "Omega below 62.8318531 rad/s"


def test_the_signal_of_a_condition_is_recorded():
    assert plan(extra='record.variables = ["rotor.*"]\n' + STOP).recorded == (
        "Omega", "rotor.d1.u", "rotor.d2.u", "sampler.i", "rotor.x"
    )  # fmt: skip


CLOSE = "[[speed]]\ntime = 0.2\nOmega = '90 rad/s'\n[[speed]]\ntime = 0.2001\nOmega = '80 rad/s'\n"
SIGNED = interface(*(replace(port, minimum=-1e4) for port in INTERFACES["sampler"].ports.values()))
TOO_FAST = ("Omega", "600 rad/s", ">= 0", "<= 500 rad/s")
OF_SCENARIO = [  # in place of a text of the scenario, whose name the message has
    ("inputs.rotor", "inputs.rotr", ("no component 'rotr'", "rotor")),
    ("set.rotor", "set.rotr", ("no component 'rotr'", "rotor")),
    ("d2.u", "d2.v", ("rotor", "d2.v", "d2.u")),
    ('"5 g.m"', '"5 mm"', ("rotor.d1.u", "5 mm", "kg.m")),
    ("", "parameters.sampl.k_x = 1\n", ("no component 'sampl'", "sampler")),
    ("", "stop = [{ variable = 'rotor.y', above = 1 }]\n", ("stop", "'rotor.y'")),
    ("", "record.variables = ['rotor.y']\n", ("record.variables", "'rotor.y'")),
]
OF_STOP = [
    ("sampler.i", "sampler.ii", ("stop", "'sampler.ii'", "sampler.i")),
    ("sampler.i", "sampler.k_x", ("stop", "'sampler.k_x'")),
    ("2 kA", "2 kN", ("stop", "sampler.i", "'2 kN'", "kN", "A")),
    ("10 Hz", "-10 kHz", ("stop", "Omega", ">= -10000", "<= 10000 rad/s")),
]
REFUSED = [  # arguments of `plan`, and facts of the message
    *(({"scenario": SCENARIO.replace(old, new, 1)}, ("scenario mine", *facts)) for old, new, facts in OF_SCENARIO),
    *(({"extra": STOP.replace(old, new)}, facts) for old, new, facts in OF_STOP),
    ({"extra": 'record.variables = ["rotr.*"]\n'}, ("nothing matches 'rotr",)),
    ({"scenario": SCENARIO.replace("10 g.m", "60 g.m")}, ("unbalance_factor", "rotor.d1.u", "0.12 kg.m")),
    ({"settings": {"rotor.Omega": 600}}, TOO_FAST),
    ({"scenario": SCENARIO + RUN_UP.replace("300", "600")}, TOO_FAST),
    *(  # -960 rpm turn -16 times a second, 100.531 rad/s
        ({"settings": {name: "-960 rpm"}, "sampler": SIGNED}, ("Omega", "-960 rpm", ">= 0 rpm"))
        for name in ("Omega", "rotor.Omega")
    ),
    ({"scenario": SCENARIO + CLOSE}, ("Omega", "0.2001 s", "0.00025 s")),
    ({"scenario": SCENARIO + OF_SPEED + RUN_UP}, ("event", "Omega", "profile")),
    ({"scenario": SCENARIO + RUN_UP, "system": replace(SYSTEM, signals=SYSTEM.signals[:1])}, ("Omega_dot", "Omega")),
    (
        {"settings": {"sampler.sample_time": "200 us"}, "sampler": ANY_STEP},
        ("sampler.sample_time", "0.0002 s", "0.00025 s"),
    ),
    ({"scenario": SCENARIO.replace("cycle = 5\n", "")}, ("event step", "cycle", "time")),
    ({"extra": 'parameters.rotor."d1.u" = 1\n'}, ("rotor.d1.u", "input", "parameter")),
    ({"extra": "inputs.sampler.k_x = 1\n"}, ("sampler.k_x", "parameter", "input")),
    (
        {"extra": "event = [{ time = 0.1, set.sampler.k_x = 2 }]\n", "scenario": NO_EVENTS},
        ("sampler.k_x", "parameter", "input"),
    ),
    ({"until": "3 mm"}, ("until", "'3 mm'", "unit mm", "s")),
    ({"until": 0.0001}, ("until", "0.0001 s")),
]


@pytest.mark.parametrize(("arguments", "facts"), REFUSED)
def test_a_scenario_that_its_components_contradict_is_refused(arguments, facts):
    with raises_naming(ValueError, *facts):
        plan(**arguments)


def test_settings_are_names_and_values():
    assert parse_settings(["a.b=1 mm", " c.d = 2 ", "a.b=3"]) == {"a.b": "3", "c.d": "2"}
    for text in ("a.b", "=1", "a.b="):
        with raises_naming(ValueError, "component.variable=value"):
            parse_settings([text])


def test_an_interrupt_waits_for_a_safe_moment():
    before = signal.getsignal(signal.SIGINT)
    with deferred() as interruption:
        os.kill(os.getpid(), signal.SIGINT)
        assert interruption.received
        assert signal.getsignal(signal.SIGINT) is before, "a second one ends the process"
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(("name", "recorded"), [("sampler.i", ["sampler.i"]), ("sampler.*", ["sampler.i"])])
def test_outputs_of_a_replacing_component_are_recorded_by_name(name, recorded):
    """Those of `rotor` are recorded, too, and an output that the component lacks is left out."""
    record = f'record.variables = ["{name}", "sampler.j", "rotor.x"]\n'
    prepared = plan(system=SYSTEM.with_fmu("sampler", "folder/own.fmu"), extra=record)
    assert sorted(prepared.recorded) == sorted([*recorded, "rotor.x"])
