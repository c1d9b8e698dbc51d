"""The assembled controller: sampling, refusals, defaults, state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amb_actuator.actuator import INTERFACE as ACTUATOR
from amb_actuator.force import current_stiffness, limited_current, negative_stiffness
from fmi_export.model import Fault, Instance
from rolac_controller.controller import INTERFACE, MODEL
from rolac_controller.table import pack

AXES = [(b, a) for b in ("mb1", "mb2") for a in "xy"]


def actuator(name):
    return ACTUATOR[name].start


@pytest.mark.parametrize(("b", "a"), AXES)
def test_default_bearing_constants_and_limits_are_those_of_the_actuator(b, a):
    geometry = [actuator(f"{b}.{n}_{a}") for n in ("turns", "pole_area", "gap", "half_angle")]
    bias, static, limit = (actuator(f"{b}.{n}_{a}") for n in ("bias_current", "static_current", "current_limit"))
    assert INTERFACE[f"{b}.k_s_{a}"].start == pytest.approx(negative_stiffness(*geometry, bias, static), rel=1e-14)
    assert INTERFACE[f"{b}.k_i_{a}"].start == pytest.approx(current_stiffness(*geometry, bias, static), rel=1e-14)
    assert INTERFACE[f"{b}.i_min_{a}"].start == pytest.approx(limited_current(-1e9, bias, static, limit))
    assert INTERFACE[f"{b}.i_max_{a}"].start == pytest.approx(limited_current(1e9, bias, static, limit))


def test_initialisation_is_no_sample(bench):
    once, often = bench(), bench()
    for b, initialisations in ((once, 1), (often, 5)):
        b["s5"] = 1e-5
        for _ in range(initialisations):
            b.instance.initialise()
        b["s5"] = 2e-5
        b.sample()
    assert once["mb1.i_x"] == often["mb1.i_x"]
    np.testing.assert_array_equal(once.instance.state, often.instance.state)


def test_current_answers_the_displacement_of_the_same_sample(bench):
    b = bench(mb1__c_b_x=0.0)
    for x in (1e-5, -3e-5, 2e-5):
        b["s5"] = x
        b.sample()
        assert b["mb1.i_x"] == pytest.approx(-(1e6 + b["mb1.k_s_x"]) * x / b["mb1.k_i_x"], rel=1e-14)


@pytest.mark.parametrize("step", [125e-6, 250e-6 * (1 + 1e-8), 1.0])
def test_step_that_is_no_sample_is_refused(bench, step):
    b = bench()
    with pytest.raises(Fault, match=r"step size.*sample_time = 0\.00025 s"):
        b.instance.step(0.0, step)
    assert b["fault_code"] == 1


def test_step_that_a_master_got_by_subtracting_times_is_accepted(bench):
    b = bench()
    for n in (0, 1, 12345, 4 * 3600 * 4000, 365 * 24 * 3600 * 4000):
        b.instance.step(n * 250e-6, (n + 1) * 250e-6 - n * 250e-6)


def test_other_sample_times_work(bench):
    h = 1e-4
    b = bench(sample_time=h, Omega=2.0 * math.pi / (125 * h))
    b.follow(lambda theta: np.full(8, 1e-4 * math.cos(theta)), 130)
    np.testing.assert_allclose(b.components(), 1e-4, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("s3", math.nan, r"s3 = nan m .* >= -0\.1 and <= 0\.1 m"),
        ("s3", 250.0, r"s3 = 250 m .* <= 0\.1 m"),
        ("theta", math.inf, r"theta = inf rad .* >= -1e\+09 and <= 1e\+09 rad"),
        ("Omega", -1.0, "Omega = -1 rad/s .* >= 0 rad/s"),
        ("Omega", math.nan, "Omega = nan rad/s"),
        ("mb2.k_i_y", 0.0, r"mb2\.k_i_y = 0 N/A .* >= 1 N/A"),
        ("rolac.alpha", -7.0, r"rolac\.alpha = -7 1/s"),
    ],
)
def test_value_out_of_range_is_refused_by_name_and_range(bench, name, value, sentence):
    b = bench()
    b[name] = value
    with pytest.raises(Fault, match=sentence):
        b.instance.step(0.0, b.h)


def test_rolac_without_a_table_is_refused(bench):
    b = bench()
    b["rolac_enable"] = 1.0
    with pytest.raises(Fault, match="without a table of receptances"):
        b.sample()
    with pytest.raises(Fault, match="without a table of receptances"):
        b.instance.initialise()


def test_outputs_before_the_first_sample_have_no_synchronous_part(bench, receptance):
    b = bench(pack([1.0], [receptance]), Omega=300.0)
    b["rolac_enable"] = 1.0
    b.sense(np.full(8, 1e-5))
    b.instance.initialise()
    assert not b.components().any()
    assert not b.forces().any()
    assert b["window_valid"] == b["rolac_active"] == 0.0
    assert b["mb1.i_x"] < 0.0


def test_run_continued_from_a_copied_state_is_identical(bench, receptance):
    table = pack([50.0, 400.0], [receptance, 2.0 * receptance])
    first = bench(table, Omega=2.0 * math.pi * 30.3, mb1__k_integral_x=1e6, derivative_time=1e-3)
    first["rolac_enable"] = 1.0

    def signal(theta):
        return 1e-4 * np.cos(theta + np.arange(8.0)) + 2e-5 * np.cos(3 * theta)

    first.follow(signal, 777)
    second = bench(table)
    second.instance = Instance(MODEL, table)
    second.instance.values[:] = first.instance.values
    second.instance.state[:] = first.instance.state
    second.n, second.theta = first.n, first.theta
    assert first["rolac_active"] == 1.0
    for _ in range(500):
        first.follow(signal, 1)
        second.follow(signal, 1)
        np.testing.assert_array_equal(first.instance.outputs, second.instance.outputs)
    np.testing.assert_array_equal(first.instance.state, second.instance.state)


def test_direct_dependencies_are_declared_and_no_more(bench, receptance):
    """One changed input of a sample changes only outputs that name it; sensors reach all that name them."""
    table = pack([50.0, 400.0], [receptance, 2.0 * receptance])

    def outputs_after(name="", change=0.0):
        b = bench(table, Omega=2.0 * math.pi * 30.3)
        b["rolac_enable"] = 1.0
        b.follow(lambda theta: 1e-5 * np.cos(theta + np.arange(8.0)), 400)
        if name == "theta":
            b.theta += change
        elif name:
            b[name] = change - b[name] if name == "rolac_enable" else b[name] + change
        b.sample()
        return b.instance.outputs.copy()

    changes = {"Omega": 1.0, "theta": 0.01, "rolac_enable": 1.0} | {f"s{k}": 1e-6 for k in range(1, 9)}
    before = outputs_after()
    for name, change in changes.items():
        after = outputs_after(name, change)
        for k, v in enumerate(INTERFACE.of("output")):
            if before[k] != after[k]:
                assert name in v.depends_on, f"{v.name} depends on {name}"
            elif name.startswith("s") and name in v.depends_on:
                pytest.fail(f"{v.name} does not depend on {name}")
