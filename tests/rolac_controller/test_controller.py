"""The assembled controller: sampling, refusals, defaults, state, robustness."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rig import ACTUATOR, AXES, CONTROLLER, NO_TABLE, pack

from amb_actuator.force import current_stiffness, limited_current, negative_stiffness
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from fmi_export.model import Fault, Instance
from rolac_controller.controller import FAULT_NO_TABLE
from rolac_controller.enumerations import MODES
from tests.support.messages import raises_naming

INTERFACE = CONTROLLER.interface


def actuator(name):
    return ACTUATOR.interface[name].start


@pytest.mark.parametrize(("b", "a"), AXES)
def test_default_bearing_constants_and_limits_are_those_of_the_actuator(b, a):
    p = axis_parameters(b, a)
    bias, static, limit = (actuator(f"{b}.{n}_{a}") for n in ("bias_current", "static_current", "current_limit"))
    assert INTERFACE[f"{b}.k_s_{a}"].start == pytest.approx(negative_stiffness(p), rel=1e-14)
    assert INTERFACE[f"{b}.k_i_{a}"].start == pytest.approx(current_stiffness(p), rel=1e-14)
    assert INTERFACE[f"{b}.i_min_{a}"].start == pytest.approx(limited_current(-1e9, bias, static, limit, 0.0))
    assert INTERFACE[f"{b}.i_max_{a}"].start == pytest.approx(limited_current(1e9, bias, static, limit, 0.0))


def test_initialisation_takes_no_sample(bench):
    once, often = bench(), bench()
    for b, initialisations in ((once, 1), (often, 5)):
        b["s5"] = 1e-5
        for _ in range(initialisations):
            b.instance.initialise()
        b["s5"] = 2e-5
        b.sample()
    assert once["mb1.i_x"] == often["mb1.i_x"]
    np.testing.assert_array_equal(once.instance.state, often.instance.state)


def test_rolac_without_a_table_is_refused(bench):
    b = bench()
    b["rolac_enable"] = 1.0
    with raises_naming(Fault, "table of receptances"):
        b.sample()
    with raises_naming(Fault, "table of receptances"):
        b.instance.initialise()


def test_outputs_before_the_first_sample_have_no_synchronous_part(bench, receptance):
    b = bench(pack([1.0], [receptance]), Omega=300.0, rolac_enable=1.0)
    b.sense(np.full(8, 1e-5))
    b.instance.initialise()
    assert not b.components().any()
    assert not b.forces().any()
    assert b["window_valid"] == b["rolac_active"] == 0.0
    assert b["mb1.i_x"] < 0.0


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        ({"harmonic2__order": 1}, ("1, 1, 0, 0", "ascend")),
        ({"harmonic1__order": 3, "harmonic2__order": 2}, ("3, 2, 0, 0",)),
        ({"harmonic3__order": 4}, ("1, 0, 4, 0",)),
        ({"plane2__z": 0.624}, ("plane2.z = 0.624 m", "plane3.z = 0.624 m")),
        ({f"s{k}__weight": 0.0 for k in range(1, 7)}, ("weights", "condition number", "10000")),
    ],
)
def test_inconsistent_parameters_are_refused_at_initialisation(bench, receptance, given, facts):
    with raises_naming(Fault, *facts):
        bench(pack([1.0], [receptance]), **given)


def everything_on(bench, receptance, **parameters):
    """A controller with all that has a memory, and something for it to remember."""
    table = pack([50.0, 400.0], [[receptance, 2.0 * receptance], [receptance, 1j * receptance]], orders=(1, 2))
    return bench(
        table,
        Omega=2.0 * math.pi * 40.3,
        sample_time=1e-3,
        mb1__k_integral_x=1e6,
        derivative_time=1e-3,
        harmonic2__order=2,
        identification__multi=1,
        chain__preset=1,
        contact__source=1,
        contact__aware=1,
        rolac_enable=1.0,
        s3__fault_noise=1e-6,
        mb2__set_y=1e-5,
        **parameters,
    )


def signal(theta):
    return 1e-4 * np.cos(theta + np.arange(8.0)) + 2e-5 * np.cos(2 * theta)


@pytest.mark.parametrize("identify", [0.0, 1.0])
def test_run_continued_from_a_copied_state_is_identical(bench, receptance, identify):
    """The copy is made between two samples, and both look ahead."""
    first = everything_on(bench, receptance, prediction_time=5e-4)
    first["identify"] = identify
    first.h *= 0.3
    first.follow(signal, 2590)
    second = first.copy()
    assert first["rolac_active"] == 1.0 - identify
    assert (first["identification_progress"] > 0.0) == (identify > 0.0)
    for _ in range(1500):
        first.follow(signal, 1)
        second.follow(signal, 1)
        np.testing.assert_array_equal(first.instance.outputs, second.instance.outputs)
    np.testing.assert_array_equal(first.instance.state, second.instance.state)


def test_no_value_of_the_scratch_array_carries_over_between_samples(bench, receptance):
    clean, dirty = everything_on(bench, receptance), everything_on(bench, receptance)
    for b in (clean, dirty):
        b["identify"] = 1.0
    for _ in range(300):
        for b in (clean, dirty):
            dirty.instance.work[:] = np.nan
            b.follow(signal, 1)
        np.testing.assert_array_equal(clean.instance.outputs, dirty.instance.outputs)


@st.composite
def histories(draw):
    """Parameters, and intervals in which inputs jump to any allowed value."""
    parameters = {
        "sample_time": draw(st.sampled_from([250e-6, 1e-3, 0.02])),
        "rolac.mode": draw(st.integers(0, len(MODES.items) - 1)),
        "chain.preset": draw(st.integers(0, 2)),
        "chain.noise": draw(st.integers(0, 1)),
        "chain.delay": draw(st.integers(0, 1)),
        "contact.source": draw(st.integers(0, 2)),
        "contact.aware": draw(st.integers(0, 1)),
        "harmonic2.order": draw(st.sampled_from([0, 2, 50])),
        "rolac.alpha": draw(st.floats(0.0, 1e3)),
        "rolac.force_limit": draw(st.floats(0.0, 1e5)),
        "rolac.min_speed": draw(st.sampled_from([0.0, 31.4])),
        "mb1.k_integral_x": draw(st.floats(0.0, 1e9)),
        "mb2.k_b_y": draw(st.floats(-1e8, 1e8)),
        "derivative_time": draw(st.floats(0.0, 10.0)),
        "plane1.offset": draw(st.sampled_from([0.0, -0.3])),
        "chain.seed": draw(st.integers(0, 2**31 - 1)),
    }
    displacement = st.floats(-0.1, 0.1)
    piece = st.fixed_dictionaries(
        {
            "Omega": st.one_of(st.floats(-1e4, 1e4), st.floats(30.0, 300.0)),
            "s1": displacement,
            "s5": displacement,
            "rolac_enable": st.integers(0, 1),
            "identify": st.integers(0, 1),
            "contact_state": st.integers(0, 3),
            "shown_harmonic": st.integers(1, 4),
            "s5.fault_dead": st.integers(0, 1),
            "s6.fault_stuck": st.integers(0, 1),
            "s4.fault_offset": displacement,
            "s3.fault_noise": st.floats(0.0, 0.1),
            "mb1.set_x": displacement,
        },
        optional={"theta": st.floats(-1e9, 1e9)},
    )
    return parameters, draw(st.booleans()), draw(st.lists(piece, min_size=1, max_size=6))


@settings(max_examples=60)
@given(histories())
def test_any_allowed_input_gives_finite_outputs_within_their_ranges(history):
    """The instance checks each output; only ROLAC without a table may be refused."""
    parameters, with_table, pieces = history
    rng = np.random.default_rng(7)
    r = 1e-6 * (rng.normal(size=(2, 8, 4)) + 1j * rng.normal(size=(2, 8, 4)))
    x = Instance(CONTROLLER, pack([50.0, 400.0], r) if with_table else NO_TABLE)
    for name, value in {**parameters, **pieces[0]}.items():
        x[name] = value
    h, n, theta = parameters["sample_time"], 0, 0.0
    try:
        x.initialise()
        for piece in pieces:
            for name, value in piece.items():
                x[name] = value
            theta = piece.get("theta", theta)
            for _ in range(60):
                x["theta"] = theta
                x["s2"] = 1e-4 * math.sin(theta)
                x.step(n * h, h)
                n += 1
                theta = math.remainder(theta + piece["Omega"] * h, 2.0 * math.pi)
    except Fault:
        assert x.fault == FAULT_NO_TABLE
        assert not with_table
    assert np.isfinite(x.state).all()


def test_declared_direct_dependencies_are_exact(bench, receptance):
    """One changed input of a sample changes only outputs that name it; sensors reach all that name them."""
    table = pack([50.0, 400.0], [[receptance, 2.0 * receptance], [receptance, 1j * receptance]], orders=(1, 2))

    def outputs_after(name="", change=0.0, **parameters):
        values = {"rolac_enable": 1.0, "s7__fault_offset": 1e-6, **parameters}
        b = bench(table, Omega=2.0 * math.pi * 30.3, harmonic2__order=2, contact__source=2, **values)
        b.follow(lambda theta: 1e-5 * np.cos(theta + np.arange(8.0)), 400)
        if name == "theta":
            b.theta += change
        elif name:
            b[name] = b[name] + change
        b.sample()
        return b.instance.outputs.copy()

    offsets = {f"plane{k}__offset": 0.01 * k for k in range(1, 5)}
    changes = {"Omega": 1.0, "theta": 0.01, "rolac_enable": -1.0, "identify": 1.0, "contact_state": 3.0}
    changes |= {f"s{k}": 1e-6 for k in range(1, 9)} | {"mb2.set_x": 1e-6, "shown_harmonic": 1.0}
    changes |= {"s3.fault_dead": 1.0, "s2.fault_stuck": 1.0, "s6.fault_offset": 1e-6, "s8.fault_noise": 1e-6}
    before = outputs_after(**offsets)
    for name, change in changes.items():
        after = outputs_after(name, change, **offsets)
        for k, v in enumerate(INTERFACE.of("output")):
            if before[k] != after[k]:
                assert name in v.depends_on, f"{v.name} depends on {name}"
            elif name in {f"s{i}" for i in range(1, 9)} and v.unit in {"m", "A"} and name in v.depends_on:
                hidden = v.name.startswith(("harmonic3", "harmonic4"))  # there are two harmonics
                assert hidden, f"{v.name} does not depend on {name}"
