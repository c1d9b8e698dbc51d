"""The energy balance: kinetic + strain energy + heat is the work of the inputs, in any contact."""

import math

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, OnePlane, both, place, plant, run

from fmi_export.model import Fault
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.contact_laws import LAWS
from rotor_contact.variables.enumerations import NEWTON, NODAL
from tests.support.messages import raises_naming

ROTOR = load_rotor()
TIGHT = {"solver.tolerance": 5e-8}
TERMS = [f"energy.{name}" for name in ("kinetic", "strain", "damping", "friction", "impact", "work")]


def largest_gap(record):
    """Of the balance, over the largest term."""
    return np.max(np.abs(record[:, -1])) / np.max(np.abs(record[:, :-1]))


def through_fig4_9(values):
    """260 rad/s, five turns with 0.5 g m, five with 25.5 g m, five with 0.5 g m on D1."""
    x = plant(TIGHT | BEARINGS | values | {"Omega": 260.0, "d1.u": 5e-4, "initial.orbit": 1.0})
    parts = []
    for unbalance in (5e-4, 25.5e-3, 5e-4):
        x["d1.u"] = unbalance
        parts.append(run(x, round(5 * 2 * math.pi / 260.0 / H), [*TERMS, "energy.balance"]))
    return np.vstack(parts)


@pytest.mark.parametrize("law", [NODAL, NEWTON])
@pytest.mark.parametrize(("mu", "e"), [(0.0, 0.0), (0.2, 0.3)])
def test_balance_closes_through_impacts_and_rubbing_of_fig4_9(law, mu, e):
    record = through_fig4_9(both("rb.mu", mu) | both("rb.restitution", e) | {"contact.impact_law": law})
    assert record[-1, 4] > 0.0
    assert largest_gap(record) < 1e-6
    heat = record[:, 2:4] if law == NODAL else record[:, 2:5]  # the nodal rule may create energy
    assert np.all(np.diff(heat, axis=0) >= -1e-9)
    assert (record[-1, 3] > 1.0) == (mu > 0.0)


@pytest.mark.parametrize("law", ["linear", "kelvin_voigt", "hunt_crossley"])
def test_balance_closes_with_compliant_contacts(law):
    values = both("rb.law", LAWS.index(law)) | both("rb.c_c", 1e4) | both("rb.alpha_c", 1.0) | both("rb.mu", 0.1)
    assert largest_gap(through_fig4_9(values)) < 1e-6


@pytest.mark.parametrize("law", ["constraint", "kelvin_voigt"])
def test_balance_closes_through_impacts_with_stribeck_friction(law):
    curve = both("rb.mu", 0.1) | both("rb.mu_static", 0.3) | both("rb.stribeck_velocity", 3.0)
    contact = both("rb.restitution", 0.3) | both("rb.law", LAWS.index(law)) | both("rb.c_c", 1e4)
    record = through_fig4_9(curve | contact)
    assert record[-1, 3] > 1.0
    assert np.all(np.diff(record[:, 3]) >= -1e-9)
    assert largest_gap(record) < 1e-6


def test_balance_closes_with_every_kind_of_input():
    """Forces with gradient, moving base, gravity, external forces, four sites, friction."""
    values = TIGHT | BEARINGS | both("rb.mu", 0.2) | {"eb1.enabled": 1.0, "eb2.enabled": 1.0, "gravity": 9.81}
    values |= {"Omega": 150.0, "d1.u": 0.02, "d3.u": 0.03, "mb1.u": 0.01, "mb2.u": 0.01, "mb2.phi": 2.0}
    values |= {"mb1.f_x": 300.0, "mb1.k_xx": 4e5, "mb1.x_ref": 1e-4, "mb2.f_y": -200.0, "mb2.k_yy": 3e5}
    values |= {"base.a_x": 3.0, "base.a_y": -8.0, "d2.f_x": 200.0, "d4.f_y": -100.0}
    x = plant(values)
    record = run(x, 2000, [*TERMS, "energy.balance", "rb1.mode", "rb2.mode", "eb1.mode"])
    assert np.all(np.max(record[:, 7:], axis=0) > 0)
    assert largest_gap(record[:, :7]) < 1e-6


def test_rolling_makes_no_heat_and_the_drive_pays_for_the_damping():
    x = plant(BEARINGS | both("rb.mu", 2.0) | {"Omega": 90.0, "d1.u": 0.094, "initial.orbit": 1.0, "rb2.enabled": 0.0})
    run(x, 400)
    record = run(x, 1000, [*TERMS, "energy.balance", "rb1.mode"])
    assert np.all(record[:, 7] == 2)
    assert np.ptp(record[:, 3]) == 0.0
    assert np.ptp(record[:, 4]) == 0.0
    gained = np.ptp(record[:, 0] + record[:, 1])
    assert record[-1, 5] - record[0, 5] == pytest.approx(record[-1, 2] - record[0, 2], abs=gained + 1e-3)
    assert largest_gap(record[:, :7]) < 1e-6


@pytest.mark.parametrize("exact", [0.0, 1.0], ids=["integrated", "pieces"])
@pytest.mark.parametrize("jump", [-5.0, 5.0])
def test_a_drive_whose_speed_jumps_supplies_the_energy_of_rolling_races(jump, exact):
    """J (w'^2 - w^2)/2 of both races; the motion of the shaft takes less than 0.5 % of that."""
    J = 1e-3
    x = plant(
        {"gravity": 9.81, "Omega": 100.0, "solver.exact_motion": exact}
        | both("rb.mu", 0.3)
        | both("rb.race_inertia", J)
    )
    run(x, 4000)
    names = (
        "rb1.race_speed",
        "rb2.race_speed",
        "energy.work",
        "energy.balance",
        "energy.friction",
        "rb1.mode",
        "rb2.mode",
    )
    before = run(x, 1, names)[-1]
    x["Omega"] = 100.0 + jump
    after = run(x, 1, names)[-1]
    assert before[5:].tolist() == after[5:].tolist() == [2.0, 2.0]
    gain = 0.5 * J * np.sum(after[:2] ** 2 - before[:2] ** 2)
    assert abs(gain) > 0.8
    assert after[2] - before[2] == pytest.approx(gain, rel=5e-3)
    assert abs(after[3] - before[3]) < 2e-6 * abs(gain)


def test_balance_improves_with_the_fourth_power_of_the_substep():
    def gap(substep):
        fixed = {"solver.max_substep": substep, "solver.tolerance": 1.0, "solver.exact_motion": 0.0}
        x = plant(BEARINGS | fixed | {"Omega": 260.0, "d1.u": 0.0255})
        place(x, *(0.2 * CLEARANCE * np.array([1, 1j, -1, 0.5, -1j, 1]) * f for f in (1.0, 50.0)))
        return abs(run(x, 60, ["energy.balance"])[-1, 0])

    gaps = np.array([gap(substep) for substep in (2.5e-4, 1.25e-4, 6.25e-5)])
    assert np.all(np.log2(gaps[:-1] / gaps[1:]) > 3.5)


def test_drive_supplies_the_heat_of_the_bearings_in_an_orbit():
    """Steady whirl: c_b Omega^2 |r|^2 at each bearing."""
    x = plant(BEARINGS | {"Omega": 90.0, "d1.u": 5e-4, "initial.orbit": 1.0})
    r = OnePlane.of(ROTOR, 1e6, 5000.0).orbit(90.0, [5e-4, 0, 0, 0])[[2, 4]]
    record = run(x, 1000, ["energy.damping", "energy.work"])
    heat = 5000.0 * 90.0**2 * np.sum(np.abs(r) ** 2) * 1000 * H
    np.testing.assert_allclose(record[-1], heat, rtol=1e-6)


UNBALANCE = {"d1.u": 0.0255}
NOT_CONSERVED = {
    "linear": {"Omega": 260.0} | both("rb.clearance", 1e-4) | both("rb.law", 1.0) | both("rb.mu", 10.0),
    "hertz": {"Omega": 260.0} | both("rb.clearance", 1e-4) | both("rb.law", 2.0) | both("rb.mu", 10.0),
    "constraint": BEARINGS
    | {"solver.exact_motion": 0.0, "Omega": 400.0, "initial.orbit": 1.0}
    | both("rb.clearance", 1e-5)
    | both("rb.mu", 2.0),
}


@pytest.mark.parametrize("law", NOT_CONSERVED)
def test_step_that_creates_energy_fails(law):
    x = plant(NOT_CONSERVED[law] | UNBALANCE)
    with raises_naming(Fault, "energy.balance", "solver.energy_limit", "0.1"):
        run(x, 100)
    assert abs(x["energy.balance"]) <= 0.1 * max(x["energy.kinetic"], x["energy.work"], x["energy.dissipated"])


def test_energy_limits_separate_warning_and_fault():
    loose = plant(NOT_CONSERVED["constraint"] | UNBALANCE | {"solver.energy_limit": 5.0})
    record = run(loose, 3, ["solver.energy_missed", "energy.balance", "energy.work"])
    assert abs(record[-1, 1]) > 0.1 * abs(record[-1, 2])
    assert not np.any(record[:, 0])
    loose = plant(NOT_CONSERVED["constraint"] | UNBALANCE | {"solver.energy_limit": 1.0})
    assert run(loose, 3, ["solver.energy_missed"])[-1, 0] == 1.0
