"""Any input gives finite outputs or a fault with its reason; and rotors other than the rig."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotor_cases import BEARINGS, CLEARANCE, H, OnePlane, both, place, plant, run

from amb_cosim.model_constants import plant_data
from fmi_export.model import Fault, Instance
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.contact_laws import CONSTRAINT
from rotor_contact.variables.enumerations import NEWTON
from tests.support.messages import raises_naming

ROTOR = load_rotor()
MODEL, CONSTANTS = plant_data.plant(ROTOR)
SITES = [site.name for site in ROTOR.sites]


def values_of(causality, scale):
    """Any set of that causality's variables: mostly of a size that means something, now and then absurd."""
    table = [v for v in MODEL.interface.of(causality) if v.name != "solver.max_substep"]
    sensible = {
        "m": 1e-3, "N": 3e3, "N/m": 3e6, "N.s/m": 1e4, "kg.m": 0.1, "rad": 7.0, "rad/s": 700.0, "m/s2": 50.0, "1": 3.0,
        "rad/s2": 1e3, "s/m": 1.0, "m/s": 1e-4, "N.m": 100.0, "N.m.s": 1.0, "kg": 10.0, "kg.m2": 1.0,
        "J/K": 1e3, "W/K": 10.0, "K": 400.0,
    }  # fmt: skip

    def one(v):
        if v.type == "Boolean":
            return st.sampled_from([0.0, 1.0])
        if v.type == "Integer":
            return st.integers(int(v.minimum), int(v.maximum)).map(float)
        size = sensible[v.unit] * scale
        return st.floats(max(v.minimum, -size), min(v.maximum, size))

    return st.lists(
        st.sampled_from(table).flatmap(lambda v: st.tuples(st.just(v.name), one(v))), max_size=25
    ).map(dict)  # fmt: skip


def survives(values, steps):
    """Step; return True on success. A fault must have a message and keep the last outputs, all finite."""
    x = Instance(MODEL, CONSTANTS)
    for name, value in values.items():
        x[name] = value
    try:
        x.initialise()
        for n in range(steps):
            x.step(n * H, H)
            assert np.all(np.isfinite(x.outputs))
            assert x["energy.kinetic"] >= 0.0
            for k in (1, 2):
                if x[f"rb{k}.enabled"] and x[f"rb{k}.law"] == CONSTRAINT:
                    assert x[f"rb{k}.gap"] >= -1e-9 * x[f"rb{k}.clearance"]
                assert x[f"rb{k}.f_n"] >= -1e-6
    except Fault:
        pass
    assert np.all(np.isfinite(x.outputs))
    assert x["fault_code"] == x.fault
    assert x.fault == 0 or len(x.message) > 20
    return x.fault == 0


@settings(max_examples=40)
@given(values_of("parameter", 1.0), values_of("input", 1.0))
def test_outputs_are_finite_or_a_fault_says_why(parameters, inputs):
    survives(BEARINGS | parameters | inputs, 60)


@settings(max_examples=30)
@given(values_of("input", 1.0))
def test_rig_with_default_parameters_goes_through_any_sensible_input(inputs):
    gradients = {name: 0.0 for name in inputs if name.endswith(("_xx", "_yy"))}
    assert survives(BEARINGS | both("rb.mu", 0.2) | both("rb.restitution", 0.5) | inputs | gradients, 60)


@settings(max_examples=40)
@given(values_of("input", 1e40))
def test_absurd_inputs_end_in_finite_numbers_or_a_fault(inputs):
    survives(BEARINGS | inputs, 10)


@pytest.mark.parametrize("gradient", [-1e12, 1e12, 1e40, 1e200])
def test_gradients_beyond_any_magnet_end_in_finite_numbers_or_a_fault(gradient):
    """No series of the motion ends with such rates: matrices with these gradients are not built."""
    survives(BEARINGS | {"mb1.k_xx": gradient, "mb2.k_yy": -gradient}, 40)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_nan_input_is_refused_by_name(value):
    x = plant()
    x["mb2.f_y"] = value
    with raises_naming(Fault, "mb2.f_y", f"{value} N"):
        x.step(0.0, H)


@pytest.mark.parametrize(("x_offset", "y_offset"), [(CLEARANCE, 0.0), (-6e-4, 6e-4), (0.0, 1.0)])
@pytest.mark.parametrize("site", ["rb1", "rb2"])
def test_retainer_offset_by_its_clearance_or_more_is_refused(site, x_offset, y_offset):
    with raises_naming(Fault, f"{site}.offset_x", "<", "0.00075 m"):
        plant({f"{site}.offset_x": x_offset, f"{site}.offset_y": y_offset})
    plant({f"{site}.offset_x": 0.999 * CLEARANCE})


@pytest.mark.parametrize(("name", "value", "allowed"), [
    ("rb1.clearance", -1e-3, (">= 1e-06", "<= 0.1 m")),
    ("rb2.restitution", 1.1, (">= 0", "<= 1")),
    ("rb2.mu", -0.1, (">= 0", "<= 10")),
    ("mb1.c_b", -1.0, (">= 0 N.s/m",)),
    ("solver.max_substep", 0.0, (">= 1e-09", "<= 0.001 s")),
    ("contact.impact_law", 2.0, ("0 (nodal)", "1 (newton)")),
    ("d1.u", -0.1, (">= 0 kg.m",)),
])  # fmt: skip
def test_value_out_of_range_is_refused_with_value_and_range(name, value, allowed):
    with raises_naming(Fault, name, f"{value:g}", *allowed):
        plant({name: value})


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.95, 1.0])
def test_two_sites_that_bounce_in_turn_do_not_exhaust_the_events(mu, e):
    """The case of Fig. 4.18 with impacts that conserve momentum, for twenty turns."""
    Omega = 90.0
    orbit = OnePlane.of(ROTOR, 1e6, 5000.0).orbit(Omega, [0.5e-3, 0, 0, 0])
    values = BEARINGS | both("rb.mu", mu) | both("rb.restitution", e)
    x = plant(values | {"Omega": Omega, "d1.u": 44.5e-3, "contact.impact_law": NEWTON})
    place(x, orbit, 1j * Omega * orbit)
    record = run(x, round(20 * 2 * math.pi / Omega / H), ["rb1.impulse", "rb2.impulse", "rb1.gap", "rb2.gap"])
    assert np.count_nonzero(record[:, 0]) >= 2
    assert np.count_nonzero(record[:, 1]) >= 2
    assert np.all(record[:, 2:] >= -1e-9)


def test_only_parameters_inputs_and_state_carry_over_between_steps():
    values = BEARINGS | both("rb.mu", 0.3) | {"Omega": 180.0, "d1.u": 0.06}
    x = plant(values)
    run(x, 300)
    assert x["contact_state"] > 0
    other = plant(values)
    other.work[:] = np.nan
    other.state[:] = x.state
    run(x, 50, start=300 * H)
    run(other, 50, start=300 * H)
    np.testing.assert_array_equal(other.state, x.state)
    np.testing.assert_array_equal(other.outputs, x.outputs)


def test_events_do_not_depend_on_the_communication_step():
    def case(steps, h):
        x = plant(BEARINGS | both("rb.restitution", 0.4) | {"Omega": 260.0, "d1.u": 0.0255, "solver.max_substep": 2e-5})
        run(x, steps, h=h)
        return x

    coarse, fine = case(40, 1e-3), case(640, 62.5e-6)
    assert coarse["energy.dissipated"] > 0.1
    for name in ("mb1.x", "mb1.y", "mb2.x", "mb2.y"):
        assert coarse[name] == pytest.approx(fine[name], abs=1e-5 * CLEARANCE)


def test_rotor_without_bearings_is_refused():
    with raises_naming(ValueError, "'bath_rig_thesis'"):
        plant_data.plant(replace(ROTOR, bearings=(), sites=ROTOR.sites[2:]))


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_no_friction_or_restitution_exhausts_the_events_of_four_sites(seed):
    """Strong friction, elastic blows, both impact laws, bushes in place: a step always ends, and the energy adds up."""
    rng = np.random.default_rng(seed)
    values = {"contact.impact_law": float(rng.integers(2)), "Omega": rng.uniform(-400, 400), "initial.orbit": 1.0}
    for site in SITES:
        values |= {f"{site}.enabled": 1.0, f"{site}.mu": rng.uniform(0, 2), f"{site}.mu_static": rng.uniform(0, 3)}
        values |= {f"{site}.stribeck_velocity": rng.choice([0.0, 0.01, 0.5])}
        values |= {f"{site}.restitution": rng.choice([0.0, 0.5, 1.0]), f"{site}.offset_x": rng.normal(scale=5e-5)}
    values |= {f"d{k}.u": 10 ** rng.uniform(-4, -1) for k in (1, 2, 3, 4)}
    x = plant(BEARINGS | values)
    record = run(
        x, 200, [*(f"energy.{name}" for name in ("kinetic", "strain", "dissipated", "work")), "energy.balance"]
    )
    assert np.max(np.abs(record[:, 4])) < 1e-3 * np.max(np.abs(record[:, :4]))


YIELDING = both("mb.k_b", 1e6) | both("mb.c_b", 5e3) | both("rb.clearance", 1e-4) | {"Omega": 90.0, "d1.u": 0.02}


@pytest.mark.parametrize("law", [
    {"rb1.law": 5.0, "rb2.law": 5.0, "rb1.alpha_c": 0.1, "rb2.alpha_c": 0.1},
    {"rb1.law": 6.0, "rb2.law": 6.0, "rb1.eta": 0.2, "rb2.eta": 0.2},
])  # fmt: skip
@pytest.mark.parametrize("h", [2e-13, 1e-17])
def test_step_far_below_the_substep_works_in_compliant_contact(law, h):
    x = plant(YIELDING | law)
    while x["contact_state"] == 0.0:
        run(x, 1)
    before = x["mb1.x"]
    run(x, 3, h=h)
    assert x["mb1.x"] == pytest.approx(before, abs=1e-11)


def test_too_stiff_contact_is_a_fault_after_bounded_substeps():
    stiff = {"rb1.law": 5.0, "rb1.alpha_c": 1000.0, "rb1.k_c": 1e12, "rb1.delta_c": 1e-9, "d1.f_x": 1e7}
    x = plant(stiff)
    with raises_naming(Fault, "100000 substeps"):
        run(x, 400)
    assert np.all(np.isfinite(x.outputs))
