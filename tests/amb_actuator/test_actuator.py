"""The actuator as a model: signs, limits, independence of its axes, declared dependencies, errors."""

import json
from pathlib import Path

import numpy as np
import pytest
from rig import ACTUATOR, ACTUATOR_CONSTANTS, AXES

from amb_actuator.interface import DYNAMIC, LAWS, MEASURED, NONLINEAR
from fmi_export.model import Fault, Instance
from tests.support.messages import raises_naming

INTERFACE = ACTUATOR.interface

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text())["amb"]
H = 250e-6
OUTPUTS = [v.name for v in INTERFACE.of("output")]

axes = pytest.mark.parametrize(("b", "a"), AXES, ids=[f"{b}-{a}" for b, a in AXES])


@pytest.fixture
def actuator(bearing):
    return bearing()


def after_step(actuator, **inputs):
    for name, value in inputs.items():
        actuator[name.replace("__", ".")] = value
    actuator.step(0.0, H)
    return actuator


@axes
def test_a_positive_current_pulls_towards_positive_x(actuator, b, a):
    actuator[f"{b}.i_{a}"] = 1.0
    actuator.step(0.0, H)
    assert actuator[f"{b}.f_{a}"] == pytest.approx(563.15, abs=0.005)


@axes
def test_a_displaced_rotor_is_pulled_further_away(actuator, b, a):
    for x in (1e-4, -1e-4):
        actuator[f"{b}.{a}"] = x
        actuator.step(0.0, H)
        assert actuator[f"{b}.f_{a}"] == pytest.approx(2.376956e6 * x, rel=1e-6)
    assert actuator[f"{b}.k_{a}{a}"] > 0


def of_axis(name, b, a):
    return name.startswith(f"{b}.") and name.endswith((f"_{a}", f".{a}", f".{a}_ref", f".k_{a}{a}"))


def differing(one, other):
    return {name for name in OUTPUTS if one[name] != other[name]}


@axes
@pytest.mark.parametrize("causality", ["parameter", "input"])
def test_an_axis_depends_on_its_own_variables_alone(bearing, b, a, causality):
    """Each parameter and input of an axis changes some output of that axis in some mode, and none of another axis."""
    modes = [
        {"force_law": law, "amplifier": amplifier, "mean_current": mean, f"{b}.i_{a}": i_c, f"{b}.{a}": 2e-4}
        for law, amplifier, mean in ((0, 0, 0), (MEASURED, 0, 0), (NONLINEAR, DYNAMIC, 1))
        for i_c in (0.2, 9.0)
    ]
    local = [v for v in INTERFACE.of(causality) if of_axis(v.name, b, a)]
    assert len(local) == (18 if causality == "parameter" else 7)
    for v in local:
        changed = set()
        for mode in modes:
            start = mode | {f"{b}.command_voltage_{a}": 0.2}
            values = start.get(v.name, v.start)
            value = 1.0 if v.type == "Boolean" else 0.9 * values if values else 0.5
            plain, moved = bearing(start), bearing(start | ({v.name: value} if causality == "parameter" else {}))
            moved[v.name] = value
            for made in (plain, moved):
                made[f"{b}.i_{a}"] -= 0.3  # something must be under way for a stuck current to differ
                made.step(0.0, H)
            changed |= differing(plain, moved)
            for made in (plain, moved):  # the voltage of the supply matters while the amplifier is off
                made[f"{b}.amplifier_off_{a}"] = 1.0
                made.step(H, H)
            changed |= differing(plain, moved)
        assert changed, v.name
        assert all(of_axis(name, b, a) for name in changed), v.name


def test_outputs_depend_without_delay_on_their_declared_inputs_alone(bearing):
    """At initialisation, from a hundred operating points."""
    rng = np.random.default_rng(2006)
    seen = {name: set() for name in OUTPUTS}
    ranges = {"mb1.i_x": (-6, 6), "mb1.x": (-6e-4, 6e-4), "mb1.command_voltage_x": (-3, 3)}
    ranges |= {"mb1.coil_loss_upper_x": (0, 1), "mb1.coil_loss_lower_x": (0, 1)}
    for _ in range(100):
        start = {"force_law": NONLINEAR} | {name: rng.uniform(*ends) for name, ends in ranges.items()}
        moves = {name: rng.uniform(*ends) for name, ends in ranges.items()} | {"mb1.amplifier_off_x": 1.0}
        if rng.random() < 0.5:  # no current flows in a coil pair that has lost all its turns
            moves |= {"mb1.coil_loss_upper_x": 1.0, "mb1.coil_loss_lower_x": 1.0}
        for name, value in moves.items():
            for output in differing(bearing(start), bearing(start | {name: value})):
                seen[output].add(name)
    for v in INTERFACE.of("output"):
        # A stuck current, and the voltage limit, need a step to show.
        declared = set(v.depends_on) - {"mb1.stuck_x"} if of_axis(v.name, "mb1", "x") else set()
        assert seen[v.name] == (set() if v.name == "mb1.voltage_limited_x" else declared), v.name


@pytest.mark.parametrize(
    ("demand", "upper", "lower", "clipped"),
    [
        (0.0, 5.57, 4.43, 0.0),
        (4.4, 9.97, 0.03, 0.0),
        (4.5, 10.0, 0.0, 1.0),
        (100.0, 10.0, 0.0, 1.0),
        (-5.5, 0.07, 9.93, 0.0),
        (-5.6, 0.0, 10.0, 1.0),
        (-100.0, 0.0, 10.0, 1.0),
    ],
)
def test_coil_currents_stay_between_zero_and_ten_ampere(actuator, demand, upper, lower, clipped):
    after_step(actuator, mb1__i_x=demand)
    assert actuator["mb1.i_upper_x"] == pytest.approx(upper, abs=1e-12)
    assert actuator["mb1.i_lower_x"] == pytest.approx(lower, abs=1e-12)
    assert actuator["mb1.clipped_x"] == clipped


@pytest.mark.parametrize("name", ["mb1", "mb2"])
def test_the_measured_constants_are_those_of_figure_2_5(bearing, name):
    made = bearing({"force_law": MEASURED, f"{name}.i_x": 1.0})
    assert made[f"{name}.k_xx"] == THESIS["k_s_measured_N_per_m"][name]
    assert made[f"{name}.f_x"] == THESIS["k_i_measured_N_per_A"][name]


@axes
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("law", range(len(LAWS)))
def test_rotor_beyond_the_air_gap_is_a_fault_with_value_and_limit(bearing, b, a, sign, law):
    actuator = bearing(force_law=law)
    name = f"{b}.{a}"
    for beyond in (1.2e-3, 1.3e-3):
        actuator.initialise()
        actuator[name] = sign * beyond
        with raises_naming(Fault, f"{name} = {sign * beyond:g} m", f"|{name}| < 0.0012 m"):
            actuator.step(0.0, H)
        assert np.all(np.isfinite(actuator.outputs))
        actuator[name] = 0.0


def test_every_axis_has_its_own_fault_codes():
    codes = set()
    for b, a in AXES:
        cases = ((f"{b}.{a}", 1.2e-3), (f"{b}.bias_current_{a}", 9.0), (f"{b}.voltage_limit_{a}", 2.0))
        for name, value in cases:
            made = Instance(ACTUATOR, ACTUATOR_CONSTANTS)
            made["amplifier"] = DYNAMIC
            made[name] = value
            with pytest.raises(Fault) as caught:
                made.initialise()
            assert f"{name} = {value:g}" in str(caught.value)
            assert made["fault_code"] == caught.value.code
            codes.add(caught.value.code)
    assert codes == set(ACTUATOR.faults)


@pytest.mark.parametrize(
    ("name", "value", "facts"),
    [
        (
            "mb2.bias_current_y",
            9.0,
            ("mb2.bias_current_y", "9 A", "mb2.static_current_y", "1.14 A", ">= 0 A", "10 A"),
        ),
        (
            "mb1.static_current_x",  # the upper pair would have to carry less than no current
            -5.0,
            ("mb1.bias_current_x", "4.43 A", "mb1.static_current_x", "-5 A", ">= 0 A", "10 A"),
        ),
        (
            "mb1.voltage_limit_x",
            2.0,
            (
                "mb1.voltage_limit_x",
                "2 V",
                "mb1.bias_current_x",
                "4.43 A",
                "mb1.static_current_x",
                "1.14 A",
                "mb1.resistance_x",
                "0.365 Ohm",
            ),
        ),
    ],
)
def test_constants_that_contradict_each_other_are_refused(name, value, facts):
    made = Instance(ACTUATOR, ACTUATOR_CONSTANTS)
    made["amplifier"] = DYNAMIC
    made[name] = value
    with raises_naming(Fault, *facts) as caught:
        made.initialise()
    assert np.all(np.isfinite(made.outputs))
    assert made["fault_code"] == caught.value.code


def test_a_refused_step_leaves_the_currents_as_they_were(bearing):
    """Also those of the axes before the faulty one."""
    actuator = bearing(amplifier=DYNAMIC)
    before = actuator.state.copy()
    actuator["mb1.i_x"], actuator["mb2.y"] = 1.0, 2e-3
    with pytest.raises(Fault):
        actuator.step(0.0, H)
    np.testing.assert_array_equal(actuator.state, before)


@pytest.mark.parametrize("amplifier", [0, DYNAMIC])
def test_outputs_do_not_depend_on_the_content_of_scratch_arrays(bearing, amplifier):
    made = [bearing(force_law=NONLINEAR, amplifier=amplifier) for _ in range(2)]
    for actuator in made:
        after_step(actuator, mb1__x=1e-4, mb2__i_y=2.0)
    made[1].work[:] = np.nan
    made[1]._next_outputs[:-1] = np.nan
    for actuator in made:
        actuator.step(H, H)
    np.testing.assert_array_equal(made[1].outputs, made[0].outputs)
