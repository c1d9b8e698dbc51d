"""Exact free flight at constant speed: an independent integration, energies, and when it ends."""

import numpy as np
import pytest
from free_motion import COMPLEX_UNBALANCE, START, START_VELOCITY, UNBALANCE, WIDE, exact_motion
from instances import initialised
from machines import SITES, held, machine
from rotor_cases import BEARINGS, CLEARANCE, H, both, masters, place, plant, run, size_of, state

from amb_cosim.model_constants import plant_data
from rotor_analysis.rotor import ReductionOptions
from rotor_contact.layout import N_HEAD
from rotor_contact.matrices.matrix_schedule import STEPS_BEFORE_BUILD
from rotor_contact.variables.enumerations import EXACT, NO_MATRICES

FINE = {"solver.max_substep": 5e-6, "solver.exact_motion": 0.0, "solver.tolerance": 1.0}
TERMS = [f"energy.{name}" for name in ("kinetic", "strain", "damping", "work", "balance")]


def in_flight(values, h=H):
    """Return a plant at START, after enough equal steps to take its next step of length h exactly."""
    x = plant(values)
    run(x, STEPS_BEFORE_BUILD + 1, h=h)
    return place(x, START, START_VELOCITY)


def flies(x):
    return x["solver.method"] == EXACT


def reset_energies(x):
    """Set the heat and work so far to zero."""
    state(x)[2 * size_of(x) :] = 0.0


@pytest.mark.parametrize("h", [H, 1e-3, 5e-3])
@pytest.mark.parametrize("Omega", [150.0, -150.0, 400.0])
def test_exact_flight_matches_an_independent_integration_for_any_step(Omega, h):
    steps = round(0.1 / h)
    x = in_flight(WIDE | BEARINGS | UNBALANCE | {"Omega": Omega}, h)
    began = x["theta"]
    run(x, steps, h=h)
    assert flies(x)
    r, v = exact_motion(Omega, steps * h, unbalance=np.array(COMPLEX_UNBALANCE) * np.exp(1j * began))
    q, w = masters(x)
    np.testing.assert_allclose(q, r, atol=1e-10 * np.max(np.abs(r)))
    np.testing.assert_allclose(w, v, atol=1e-10 * np.max(np.abs(v)))


@pytest.mark.parametrize("free", [{}, {"spin.free": 1.0, "spin.inertia": 1e9}])
def test_a_run_is_exact_from_its_second_step(free):
    """From rest, under gravity and unbalance: before, the substeps of 32 steps decided how accurate a run was."""
    rotor = machine(reduction=ReductionOptions(modes=6))
    apart = {f"{site}.enabled": 0.0 for site in SITES}
    values = held(3) | apart | free | {"gravity": 9.81, "Omega": 300.0, "impeller5.u": 1e-3}
    fine = {"solver.exact_motion": 0.0, "solver.max_substep": 1e-6}
    x, reference = (initialised(*plant_data.plant(rotor), values | more) for more in ({}, fine))
    for n in range(32):
        run(x, 1, start=n * H)
        run(reference, 1, start=n * H)
        assert x["solver.method"] == (EXACT if n > 0 else NO_MATRICES)
    difference = np.abs(state(x)[: size_of(x)] - state(reference)[: size_of(x)])
    assert np.max(difference) < 1e-6 * np.max(np.abs(state(reference)[: size_of(x)]))
    assert abs(x["energy.balance"]) < 1e-8 * x["energy.kinetic"]


EVERY_INPUT = {
    "Omega": 150.0, "gravity": 9.81, "mb1.u": 2e-4, "mb2.u": 1e-4, "mb2.phi": 2.0,
    "mb1.f_x": 30.0, "mb1.k_xx": -4e5, "mb1.x_ref": 1e-5, "mb2.f_y": -20.0, "mb2.k_yy": 3e5,
    "base.a_x": 0.3, "base.a_y": -0.8, "d2.f_x": 20.0, "d4.f_y": -10.0,
}  # fmt: skip


def test_every_input_acts_in_flight_as_it_does_in_the_integration():
    exact = in_flight(WIDE | BEARINGS | UNBALANCE | EVERY_INPUT)
    fine = place(plant(WIDE | BEARINGS | UNBALANCE | EVERY_INPUT | FINE), START, START_VELOCITY)
    fine.state[:N_HEAD] = exact.state[:N_HEAD]
    for x in (exact, fine):
        reset_energies(x)
    run(exact, 200)
    run(fine, 200)
    np.testing.assert_allclose(masters(exact)[0], masters(fine)[0], rtol=1e-8)
    for name in ("energy.work", "energy.damping"):
        assert exact[name] == pytest.approx(fine[name], rel=1e-7), name


@pytest.mark.parametrize("h", [H, 1e-3])
def test_energies_balance_in_flight(h):
    x = in_flight(WIDE | BEARINGS | UNBALANCE | EVERY_INPUT, h)
    reset_energies(x)
    record = run(x, 400, TERMS, h=h)
    assert np.ptp(record[:, 4]) < 1e-8 * np.max(np.abs(record[:, :4]))
    assert record[-1, 2] > 0.0
    assert np.all(np.diff(record[:, 2]) > 0.0)


def test_a_journal_that_reaches_its_retainer_in_flight_touches_it():
    values = BEARINGS | both("rb.restitution", 0.5) | {"Omega": 260.0, "d1.u": 5e-4}
    exact, fine = plant(values), plant(values | FINE)
    records = []
    for x in (exact, fine):
        run(x, 200)
        x["d1.u"] = 40e-3
        records.append(run(x, 300, ["rb1.gap", "rb1.impulse", "mb1.x", "rb2.gap"]))
    gaps = np.array([record[:, [0, 3]] for record in records])
    assert np.min(gaps) > -1e-12
    touched = [np.flatnonzero(record[:, 1])[0] for record in records]
    assert touched[0] == touched[1]
    before = touched[0]
    np.testing.assert_allclose(records[0][:before, 2], records[1][:before, 2], atol=1e-6 * CLEARANCE)


@pytest.mark.parametrize("change", [{"Omega": 151.0}, {"mb1.c_b": 300.0}])
def test_another_speed_or_passive_bearing_ends_exact_flight_for_some_steps(change):
    x = in_flight(WIDE | BEARINGS | {"Omega": 150.0})
    run(x, 1)
    assert flies(x)
    for name, value in change.items():
        x[name] = value
    run(x, 1)
    assert not flies(x)
    run(x, STEPS_BEFORE_BUILD)
    assert flies(x)


@pytest.mark.parametrize("change", [{"mb1.k_xx": 1e3}, {"mb2.f_y": 5.0}, {"d2.f_x": 3.0}, {"d1.u": 1e-4}])
def test_changed_magnets_forces_and_unbalance_keep_exact_flight(change):
    x = in_flight(WIDE | BEARINGS | {"Omega": 150.0})
    for name, value in change.items():
        x[name] = value
    run(x, 1)
    assert flies(x)


def test_a_step_of_another_length_ends_exact_flight_for_some_steps():
    x = in_flight(WIDE | BEARINGS | {"Omega": 150.0})
    run(x, 1, h=0.5 * H)
    assert not flies(x)


def test_rounding_of_speed_step_and_gradients_keeps_exact_flight():
    """A copy of the state that builds its propagator at another step than the original builds the same."""
    values = WIDE | BEARINGS | UNBALANCE | {"Omega": 150.0, "mb1.k_xx": 1e5}
    x = in_flight(values)
    other = plant(values)
    up = {"Omega": np.nextafter(150.0, 200.0), "mb1.k_xx": np.nextafter(1e5, 2e5)}
    for k in range(20):
        for name in up:
            x[name] = up[name] if k % 2 else values[name]
        run(x, 1, h=H if k % 3 else np.nextafter(H, 1.0))
        assert flies(x)
    other.state[:] = x.state
    for name in up:
        x[name] = other[name] = up[name]
    np.testing.assert_array_equal(run(x, 5, TERMS), run(other, 5, TERMS))


def test_constant_forces_and_unbalance_may_change_in_flight():
    x = in_flight(WIDE | BEARINGS | {"Omega": 150.0})
    for name, value in (("mb1.f_x", 50.0), ("d1.u", 1e-3), ("mb1.x_ref", 1e-5), ("base.a_x", 1.0)):
        x[name] = value
        run(x, 1)
        assert flies(x)


def test_a_rotor_too_stiff_for_the_series_moves_exactly_in_pieces():
    h, values = 2e-2, WIDE | both("mb.k_b", 1e9) | {"Omega": 150.0}
    x = in_flight(values, h)
    fine = place(plant(values | FINE | {"solver.max_substep": 1e-6}), START, START_VELOCITY)
    fine.state[:N_HEAD] = x.state[:N_HEAD]
    for rotor in (x, fine):
        reset_energies(rotor)
        run(rotor, 1, h=h)
    assert x["solver.method"] == EXACT
    for ours, integrated in zip(masters(x), masters(fine), strict=True):
        np.testing.assert_allclose(ours, integrated, atol=1e-5 * np.max(np.abs(integrated)))
