"""Four sites, any number of master planes, gravity, and the start on an orbit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, OnePlane, both, check_collected, masters, plant, run

from fmi_export.model import Fault
from rotor_analysis.rotor import ReductionOptions
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

ROTOR = load_rotor()
ENDS = {"eb1.enabled": 1.0, "eb2.enabled": 1.0}
SITES = ("rb1", "rb2", "eb1", "eb2")
ROW = dict(zip(SITES, (2, 4, 0, 5), strict=True))  # among the masters


@pytest.mark.parametrize("site", SITES)
def test_each_site_stops_its_own_plane_at_its_own_clearance(site):
    limits = {"rb1": 0.5e-3, "rb2": 0.6e-3, "eb1": 0.7e-3, "eb2": 0.8e-3}
    values = {f"{name}.enabled": float(name == site) for name in SITES}
    values |= {f"{name}.clearance": c for name, c in limits.items()}
    x = plant(BEARINGS | values | {"Omega": 100.0, "d1.u": 0.05, "d4.u": 0.2})
    furthest = np.zeros(6)
    touched = dict.fromkeys(SITES, False)
    for n in range(1500):
        x.step(n * H, H)
        furthest = np.maximum(furthest, np.abs(masters(x)[0]))
        for name in SITES:
            touched[name] |= x[f"{name}.mode"] > 0 or x[f"{name}.impulse"] > 0
    assert touched == {name: name == site for name in SITES}
    assert furthest[ROW[site]] <= limits[site] + 1e-12
    assert any(furthest[ROW[name]] > limits[name] for name in SITES if name != site)


def test_all_four_sites_carry_a_rotor_that_is_pressed_against_them():
    """Forces at the discs along x close all four sites. The shaft between them keeps vibrating; mean forces balance."""
    x = plant(BEARINGS | ENDS | {f"d{k}.f_x": 3e4 for k in (1, 2, 3, 4)})
    run(x, 1000)
    record = run(x, 4000, [f"{site}.{name}" for site in SITES for name in ("f_n", "impulse")])
    pressed = np.mean(record[:, ::2] + record[:, 1::2] / H, axis=0)
    assert np.all(pressed > 1e3)
    assert np.sum(pressed) + 2 * 1e6 * CLEARANCE == pytest.approx(4 * 3e4, rel=5e-3)


@pytest.mark.parametrize("master", [(1, 3, 4, 8, 10, 11, 13), tuple(range(1, 14))])
def test_more_master_planes_give_the_same_rubbing_rotor(master):
    """The quick modes that the condensed rotor does not have turn contact into blows; the mean force is the same.

    Over two seconds of a rub that has settled. Clearances that differ by 1e-9 to 1e-5 change that mean by 0.07 %; at
    higher speeds the rub beats, and its mean over a fifth of a second hangs on last bits.
    """

    def mean_force(rotor):
        short = {"solver.max_substep": 1e-5, "rb1.enabled": 0.0}
        x = plant(BEARINGS | short | {"Omega": 110.0, "d3.u": 0.08, "initial.orbit": 1.0}, rotor)
        record = run(x, 16000, ["rb2.f_n", "rb2.impulse"])[8000:]
        return np.mean(record[:, 0]) + np.mean(record[:, 1]) / H

    finer = replace(ROTOR, reduction=ReductionOptions(masters=master))
    assert mean_force(finer) == pytest.approx(mean_force(ROTOR), rel=0.01)


def test_gravity_pulls_along_both_axes_by_its_component():
    """The sag is the static deflection under m g / sqrt(2) in each axis; the energies add up to the work."""
    g = 9.81
    x = plant(both("rb.enabled", 0.0) | both("mb.k_b", 1e6) | both("mb.c_b", 3e4) | {"gravity": g})
    run(x, 16000)
    model = OnePlane.of(ROTOR, 1e6, 0.0)
    weight = model.M @ np.ones(6) * g / math.sqrt(2.0)
    sag = -np.linalg.solve(model.K, weight) * (1 + 1j)
    np.testing.assert_allclose(masters(x)[0], sag, rtol=1e-4)
    assert abs(x["energy.balance"]) < 1e-6 * x["energy.work"]


@pytest.mark.parametrize(("Omega", "angle"), [(90.0, 0.0), (-150.0, 0.0), (90.0, 0.7), (-150.0, -8.0)])
def test_start_on_the_orbit_is_the_steady_state(Omega, angle):
    u = [3e-4, 0, 2e-4 * np.exp(1j), 0]
    values = BEARINGS | {"Omega": Omega, "d1.u": 3e-4, "d3.u": 2e-4, "d3.phi": 1.0, "initial.orbit": 1.0}
    x = plant(values | {"d1.f_x": 20.0, "initial.angle": angle})
    assert x["theta"] == pytest.approx(angle % (2.0 * np.pi))
    orbit = OnePlane.of(ROTOR, 1e6, 5000.0).orbit(Omega, u) * np.exp(1j * angle)
    lift = np.linalg.solve(OnePlane.of(ROTOR, 1e6).K, 20.0 * np.eye(6)[0])
    np.testing.assert_allclose(masters(x)[0], orbit + lift, atol=1e-12)
    np.testing.assert_allclose(masters(x)[1], 1j * Omega * orbit, atol=1e-10)
    run(x, 400)
    turned = orbit * np.exp(1j * Omega * 400 * H) + lift
    np.testing.assert_allclose(masters(x)[0], turned, atol=1e-5 * np.max(np.abs(orbit)))


def test_the_orbit_at_the_start_is_that_in_the_passive_bearings():
    values = BEARINGS | {"Omega": 90.0, "d1.u": 3e-4, "initial.orbit": 1.0}
    pulled = plant(values | {"mb1.f_x": 20.0, "mb2.k_yy": 1e5, "mb2.y_ref": 1e-4})
    np.testing.assert_array_equal(masters(pulled), masters(plant(values)))
    pulled.step(0.0, H)
    assert pulled["mb1.x"] > run(plant(values), 1, ["mb1.x"])[0, 0]


def test_orbit_beyond_the_clearance_starts_in_contact_there():
    x = plant(BEARINGS | {"Omega": 90.0, "d1.u": 0.094, "initial.orbit": 1.0, "rb2.enabled": 0.0})
    assert (x["rb1.mode"], x["contact_state"], x["rb1.gap"]) == (1.0, 1.0, 0.0)
    assert abs(masters(x)[0][2]) == pytest.approx(CLEARANCE, rel=1e-12)
    assert abs(masters(x)[0][4]) > CLEARANCE
    assert x["rb1.f_n"] > 0.0


def test_orbit_without_bearings_is_refused():
    with raises_naming(Fault, "initial.orbit = 1", "mb1.k_b = 0 N/m", "mb2.k_b = 0 N/m"):
        plant({"initial.orbit": 1.0, "Omega": 50.0, "gravity": 9.81})


def test_a_step_collects_each_such_output_of_a_site_and_a_new_start_forgets_it():
    """A rotor that its unbalance drives into a rub with friction: impacts, then substeps, then pieces."""
    x = plant(BEARINGS | both("rb.mu", 0.2) | both("rb.restitution", 0.3) | {"Omega": 110.0, "d1.u": 0.08})
    check_collected(x, "rb1", 1200)
