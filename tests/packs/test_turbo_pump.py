"""The packaged turbomolecular pump stands on five axes, and is caught along and across its shaft."""

import math
from pathlib import Path

import numpy as np
import pytest

import amb_cosim
from amb_analysis.machine.machine import Machine
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_files.csv_files import read_csv
from amb_files.packs import packs
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor_file import load_rotor

G = 9.81  # m/s2, of its scenarios
GAP = 0.25e-3  # m, of its faces
TOUCHED = {
    "turbo_pump_levitation": set(),
    "turbo_pump_landing": {"seat"},
    "turbo_pump_air_inrush": {"seat", "catch_lower", "catch_upper"},
    "turbo_pump_blade_loss": {"seat", "catch_lower", "catch_upper"},
    "turbo_pump_rundown": {"seat"},
}


@pytest.fixture(scope="module")
def run():
    runs = {}
    return lambda name: runs[name] if name in runs else runs.setdefault(name, amb_cosim.run(name, progress=False))


@pytest.mark.parametrize("name", TOUCHED)
def test_it_touches_what_its_scenario_says_and_balances_its_energy(run, name):
    summary = run(name).summary
    assert summary.completed
    assert {site for site, force in summary.peak_contact_force.items() if force} == TOUCHED[name]
    assert summary.energy_balance < 1e-6
    assert TOUCHED[name] or summary.first_contact is None
    assert not TOUCHED[name] or summary.energy_balance_of_heat < 1e-5


def test_summaries_say_when_a_disturbance_begins(run):
    """It is that of the input that changes first: the process force, or the acceleration along x after 0.1 s."""
    inrush, quake = run("turbo_pump_air_inrush"), amb_cosim.run("turbo_pump_earthquake", until=0.5, progress=False)
    assert (inrush.summary.events, inrush.signals.attrs["disturbance_cycle"]) == ({"disturbance": "air inrush"}, 0.0)
    assert inrush.summary.recovery == "recovered"
    assert quake.summary.events == {"disturbance": "earthquake"}
    period = quake.signals.attrs["period_s"]
    assert quake.signals.attrs["disturbance_cycle"] * period == pytest.approx(0.1, abs=1e-4)
    assert quake.signals.attrs["last_change_cycle"] * period == pytest.approx(0.5, abs=1e-4)  # it shakes to the end
    assert quake.summary.recovery == "prevented"


def test_it_is_caught_after_an_inrush_of_air(run):
    assert run("turbo_pump_air_inrush").signals["rotor_contact.seat.gap"].values[-1] == pytest.approx(GAP, rel=0.05)


def test_it_falls_freely_onto_its_seat_and_stands_there_with_its_weight(run):
    """The magnets let it go within their discharge, which delays the fall."""
    signals = run("turbo_pump_landing").signals
    t, force = signals["time"].values, signals["rotor_contact.seat.f_n_mean"].values
    free = math.sqrt(2.0 * GAP / G)
    assert free <= t[np.flatnonzero(force)[0]] < free + 2e-3
    weight = rigid_body(load_rotor("turbo_pump")).mass * G
    assert np.mean(force[t > 0.2]) == pytest.approx(weight, rel=1e-3)


def test_it_lies_at_rest_from_when_it_stands_on_its_seat(run):
    """It falls and bounces before that, however still it is across the shaft."""
    fall = math.sqrt(2.0 * GAP / G)
    assert fall < run("turbo_pump_landing").summary.touchdown.rest_after < 0.1


@pytest.mark.parametrize("name", ["turbo_pump_landing", "turbo_pump_rundown"])
def test_heat_of_a_landing_on_a_face_includes_the_drag_of_its_race(run, name):
    """The ring turns with the rotor; all heat of friction and impacts arises at the face and in its bearing."""
    summary = run(name).summary
    (seat,) = summary.touchdown.retainers.values()
    assert seat.heat == pytest.approx(summary.energy["friction"] + summary.energy["impact"], rel=0.01)


def test_gas_and_the_balls_of_its_retainer_slow_it(run):
    """J_p Omega' = -d Omega - M_r: the race below the seat follows the rotor, and its balls brake both."""
    parameters, signals = (
        load_scenario("turbo_pump_rundown").parameters["rotor_contact"],
        run("turbo_pump_rundown").signals,
    )
    t, speed = (signals[name].values for name in ("time", "rotor_contact.speed"))
    last = t > 1.0
    drag, race = (float(str(parameters[key]).split()[0]) for key in ("spin.drag", "catch_*.race_drag"))
    expected = -(drag * np.mean(speed[last]) + race) / rigid_body(load_rotor("turbo_pump")).polar_inertia
    assert np.polyfit(t[last], speed[last], 1)[0] == pytest.approx(expected, rel=0.02)


def test_its_loop_is_stable_from_standstill_to_its_trip_speed():
    loop = Machine(prepare_run(load_scenario("turbo_pump_levitation").machine())).loop
    trip = load_rotor("turbo_pump").reduction.speed
    assert loop.least_stable(np.linspace(0.0, trip, 8)).is_stable


def test_its_earthquake_is_the_sum_of_cosines_in_its_header():
    path = Path(packs()["rotor_literature"]) / "scenarios" / "turbo_pump_earthquake.csv"
    _, rows = read_csv(path, "earthquake")
    t, *axes = np.array(rows, dtype=float).T
    n = np.arange(1, 401)
    f, ground, corner = 0.05 * n, 2.5, 0.2
    x = (2.0 * 0.6 * f / ground) ** 2
    power = (1.0 + x) / ((1.0 - (f / ground) ** 2) ** 2 + x) * f**4 / (f**4 + corner**4)
    envelope = np.minimum(np.minimum((t / 2.0) ** 2, 1.0), np.exp(-0.3 * (t - 12.0)))
    for k, (axis, peak) in enumerate(zip(axes, (3.5, 3.0, 2.3), strict=True), 1):
        phases = 2.0 * np.pi * np.modf(0.5 * (math.sqrt(5.0) - 1.0) * n**2 * k)[0]
        wave = envelope * (np.sqrt(power) * np.cos(2.0 * np.pi * f * t[:, None] + phases)).sum(axis=1)
        assert np.allclose(axis, peak * wave / np.abs(wave).max(), atol=0.011)
