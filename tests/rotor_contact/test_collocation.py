"""Contact by collocation: agreement with Runge-Kutta substeps, order, energies, and steps that it rejects."""

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, both, memory, plant, run, scratch, size_of, state, workspace

from rotor_contact.contact.constraints import number_unknowns
from rotor_contact.contact.workspace import stages_of
from rotor_contact.forces.dynamics import motion_at
from rotor_contact.matrices.speed_grid import CONSTANT
from rotor_contact.shaft.lobatto import (
    LAGRANGE,
    LOBATTO_POINTS,
    LOBATTO_WEIGHTS,
    N_LOOKS,
    least_of_cubic,
    positive_share,
)
from rotor_contact.variables.enumerations import EXACT, PIECES
from rotor_contact.whole_steps.collocation import (
    _locate_nodes,
    _solve_nodes,
    find_end_forces,
    find_first_forces,
    find_forces,
)
from rotor_contact.whole_steps.exact_motion import take_whole_step
from rotor_contact.whole_steps.whole_step import begin_whole_step
from rotor_contact.whole_steps.whole_step_rows import first_held, whole_step_of

UNBALANCE = {f"d{k}.u": 0.16 for k in (1, 2, 3, 4)}
RUBBING = both("mb.k_b", 1e6) | both("mb.c_b", 2e4) | both("rb.restitution", 0.0) | UNBALANCE | {"Omega": 260.0}
CASES = {
    "without friction": both("rb.mu", 0.0),
    "sliding": both("rb.mu", 0.1),
    "sliding with Stribeck friction": both("rb.mu", 0.05)
    | both("rb.mu_static", 0.2)
    | both("rb.stribeck_velocity", 5.0),
    "off centre": both("rb.mu", 0.1) | both("rb.offset_x", 2e-5) | both("rb.offset_y", -1e-5),
}
ROLLING = BEARINGS | both("rb.mu", 2.0) | both("rb.restitution", 0.0) | {"Omega": 90.0, "d1.u": 0.094, "d4.u": 0.094}
BOUNCING = BEARINGS | both("rb.mu", 0.1) | both("rb.restitution", 0.0) | {"Omega": 260.0, "d1.u": 0.04, "d4.u": 0.04}
FINE = {"solver.exact_motion": 0.0, "solver.tolerance": 1.0}
NAMES = ["rb1.f_n", "rb2.f_n", "rb1.f_t", "rb2.f_t", "mb1.x", "mb1.y", "mb2.x", "mb2.y"]


def is_whole(x, h=H):
    """Return whether a plant takes its next step by one product."""
    x.step(0.0, h)
    return x["solver.method"] == EXACT


def whole_step(x):
    """Return workspace, matrices and whole step of a plant, with its state at the beginning of the next step."""
    w, matrices = workspace(x, x["Omega"]), scratch(x).matrices
    w = w._replace(motion=motion_at(w.motion, x["theta"], x["Omega"]))
    stages_of(w.stages).z[: 2 * size_of(x)] = state(x)[: 2 * size_of(x)]
    begin_whole_step(w, matrices)
    return w, matrices, whole_step_of(matrices, int(matrices.sizes[0].place - CONSTANT))


def in_contact(values, steps=400, h=H):
    """A plant after some steps from rest, all sites in contact that will be."""
    x = plant(values)
    run(x, steps, h=h)
    return x


def copy_of(x, values, h=H):
    """A plant in the state of x, with other parameters, that has seen steps of length h."""
    y = plant(values)
    y.state[:] = x.state
    memory(y).matrices_key.step_size[0] = h
    return y


def beside_fine(values, x, h=H, steps=20):
    """A record of some steps from the state of x, and that of the integration in substeps of a hundredth."""
    fine = copy_of(x, values | FINE | {"solver.max_substep": h / 100.0})
    x = copy_of(x, values, h)
    record = np.empty((steps, len(NAMES)))
    for row in record:
        assert is_whole(x, h)
        row[:] = [x[name] for name in NAMES]
    assert x["rb1.mode"] + x["rb2.mode"] > 0
    return record, run(fine, steps, NAMES, h=h)


@pytest.mark.parametrize("case", CASES)
def test_collocated_step_is_accurate_to_a_ten_millionth(case):
    values = RUBBING | CASES[case]
    result, fine = beside_fine(values, in_contact(values))
    assert fine[:, :2].max() > 1e4
    np.testing.assert_allclose(result[:, :4], fine[:, :4], atol=1e-7 * fine[:, :2].max())
    np.testing.assert_allclose(result[:, 4:], fine[:, 4:], atol=1e-7 * CLEARANCE)


def test_rolling_by_a_sixth_of_a_radian_in_a_step_is_accurate():
    h = 50e-6
    x = in_contact(ROLLING, 600, h)
    assert x["rb1.mode"] == x["rb2.mode"] == 2
    assert x["rb1.whirl_speed"] * h == pytest.approx(-0.15)
    result, fine = beside_fine(ROLLING, x, h, 40)
    np.testing.assert_allclose(result[:, :4], fine[:, :4], atol=1e-8 * fine[:, :2].max())
    np.testing.assert_allclose(result[:, 4:], fine[:, 4:], atol=1e-9 * CLEARANCE)


def test_rolling_too_fast_for_one_cubic_goes_on_in_pieces():
    x = copy_of(in_contact(ROLLING, 600, 50e-6), ROLLING)
    x.step(0.0, H)
    assert x["solver.method"] == PIECES
    assert x["rb1.mode"] == 2


@pytest.mark.parametrize("case", CASES)
def test_forces_converge_in_two_sweeps_as_normals_turn(case):
    """With unchanged directions the second sweep changes forces by 6e-4 of the largest."""
    w, matrices, whole = whole_step(in_contact(RUBBING | CASES[case]))
    assert find_first_forces(w, matrices, whole)
    size, changes = number_unknowns(w.sites), []
    for _ in range(3):
        _locate_nodes(w, matrices, whole)
        solved, change = _solve_nodes(w, matrices, whole, size)
        assert solved
        changes.append(change)
    assert changes[0] > 1e-2
    assert changes[1] < 4e-5
    assert changes[2] < 1e-7


def test_collocation_fails_if_a_journal_would_have_to_be_pulled():
    w, matrices, whole = whole_step(in_contact(RUBBING))
    assert find_first_forces(w, matrices, whole)
    for k, site in enumerate(w.sites[:2]):
        at = first_held(matrices) + 2 * k
        whole.x[at : at + 2] = -1e6 * site.n_x, -1e6 * site.n_y  # N, inwards
    assert not find_first_forces(w, matrices, whole)


def test_collocation_fails_if_forces_move_no_journal():
    w, matrices, whole = whole_step(in_contact(RUBBING))
    whole.S[:] = 0.0
    assert find_first_forces(w, matrices, whole)
    assert _solve_nodes(w, matrices, whole, number_unknowns(w.sites)) == (False, 0.0)
    assert not find_forces(w, matrices, whole)


def test_a_step_that_ends_with_a_pulling_force_is_rejected():
    w, matrices, whole = whole_step(in_contact(RUBBING))
    assert find_first_forces(w, matrices, whole)
    assert find_forces(w, matrices, whole)
    end = stages_of(w.stages).z_new
    end[: 2 * w.n] = whole.x @ whole.F[:, : 2 * w.n]
    assert find_end_forces(w, whole, end)
    assert not find_end_forces(w._replace(Minv=np.zeros_like(w.Minv)), whole, end)
    for k, site in enumerate(w.sites[:2]):  # accelerations inwards, of the journal without contact
        whole.free_response[k, -2:] -= 1e5 * site.n_x, 1e5 * site.n_y
    assert not find_end_forces(w, whole, end)


def test_error_falls_with_the_fifth_power_of_the_step():
    values = RUBBING | CASES["sliding"]
    x, errors = in_contact(values), []
    for h in (H, 0.5 * H):
        result, fine = beside_fine(values, x, h, round(4 * H / h))
        errors.append(np.max(np.abs(result[-1, :2] - fine[-1, :2])))
    assert errors[0] / 100.0 < errors[1] < errors[0] / 28.0


def test_energies_balance_over_collocated_steps():
    x = in_contact(RUBBING | CASES["sliding"])
    record = run(x, 400, ["energy.balance", "energy.work", "energy.friction", "energy.damping"])
    gained = np.ptp(record, axis=0)
    assert min(gained[1:]) > 1.0
    assert gained[0] < 1e-8 * gained[1]


@pytest.mark.parametrize("steps", [100, 200, 300, 400])
def test_a_step_with_an_event_is_left_as_it_was(steps):
    x = in_contact(BOUNCING, steps)
    for _ in range(400):
        before, closed = x.state.copy(), x["contact_state"] > 0
        if not is_whole(x) and closed:
            break
    else:
        pytest.fail("there was no event")
    x.state[:] = before
    w, matrices, _ = whole_step(x)
    z = stages_of(w.stages).z.copy()
    assert not take_whole_step(w, matrices, H)
    np.testing.assert_array_equal(stages_of(w.stages).z, z)
    assert not any(site.f_n_peak for site in w.sites)


def test_lift_off_has_the_time_of_the_integration():
    values = RUBBING | CASES["sliding"]
    x = in_contact(values)
    fine = copy_of(x, values | FINE | {"solver.max_substep": 2.5e-6})
    pull = -3.0 * x["rb1.f_n"] * np.exp(1j * np.angle(x["mb1.x"] + 1j * x["mb1.y"]))
    for y in (x, fine):
        y["mb1.f_x"], y["mb1.f_y"] = pull.real, pull.imag
        y["d1.u"] = 0.0
    names = ["rb1.mode", "rb2.mode", *NAMES]
    result, expected = run(x, 8, names), run(fine, 8, names)
    assert 0.0 in expected[:, 0]
    np.testing.assert_array_equal(result[:, :2], expected[:, :2])
    np.testing.assert_allclose(result[:, -4:], expected[:, -4:], atol=1e-4 * CLEARANCE)


def test_lobatto_quadrature_is_exact_for_polynomials_of_degree_five():
    for degree in range(6):
        result = sum(weight * point**degree for weight, point in zip(LOBATTO_WEIGHTS, LOBATTO_POINTS, strict=True))
        assert result == pytest.approx(1.0 / (degree + 1), rel=1e-14)


def test_lagrange_polynomials_are_one_at_one_point_and_zero_at_others():
    values = np.array([[np.polyval(c[::-1], s) for s in LOBATTO_POINTS] for c in LAGRANGE])
    np.testing.assert_allclose(values, np.eye(4), atol=1e-14)


@pytest.mark.parametrize("seed", range(10))
def test_cubic_is_positive_up_to_its_first_falling_root(seed):
    coefficients = np.random.default_rng(seed).normal(size=4)
    coefficients[3] = abs(coefficients[3])
    share = positive_share(*np.polyval(coefficients, LOBATTO_POINTS))
    roots = np.roots(coefficients)
    first = min((r.real for r in roots if abs(r.imag) < 1e-12 and 0.0 < r.real <= 1.0), default=None)
    if first is None:
        assert share in (0.5, 1.0)
        assert share == 0.5 or np.all(np.polyval(coefficients, np.linspace(0.0, 1.0, 101)) > 0.0)
    else:
        assert share == pytest.approx(first, abs=0.5 / N_LOOKS)


@pytest.mark.parametrize("seed", range(10))
def test_bound_of_a_cubic_is_below_all_of_it_and_exact_for_lines(seed):
    coefficients = np.random.default_rng(seed).normal(size=4)
    bound = least_of_cubic(*np.polyval(coefficients, LOBATTO_POINTS))
    assert bound <= np.min(np.polyval(coefficients, np.linspace(0.0, 1.0, 1001))) + 1e-14
    line = coefficients[:2]
    assert least_of_cubic(*np.polyval(line, LOBATTO_POINTS)) == pytest.approx(
        min(line[1], line[0] + line[1]), abs=1e-14
    )
