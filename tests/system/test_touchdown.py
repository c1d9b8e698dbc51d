"""Touchdown scenarios have their stated outcomes: fall, rest, whirl and recovery."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import amb_cosim
from amb_cosim.results.result import Result

pytestmark = [pytest.mark.slow, pytest.mark.gate]

WEIGHT = 96.0254 * 9.81  # N
INERTIA = 0.40982  # kg m^2, polar
CLEARANCE = 0.75e-3  # m, of the retainers
SITES = ("rb1", "rb2", "eb1", "eb2")
RETAINERS = ("rb1", "rb2")

# Ends of the runs (s), no later than their outcome takes.
ENDS = {
    "drop": 0.5,
    "drop_no_race": 0.5,
    "drop_race": 0.5,
    "drop_mount": 0.5,
    "drop_whirl": 0.3,
    "relevitation": 0.8,
    "relevitation_rolac": 2.0,
    "one_axis_lost": 0.4,
    "amplifier_lost": 0.4,
    "sensor_lost": 0.4,
    "base_shock": 0.3,
    "blade_loss": 0.4,
}
SLOW = ("drop_whirl", "relevitation_rolac")

Run = Callable[..., Result]
all_scenarios = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in ENDS]
)


@pytest.fixture(scope="module")
def run() -> Run:
    """`run(name, until=None)`: result of a scenario, run once."""
    return cache(lambda name, until=None: amb_cosim.run(name, until=until or ENDS[name], progress=False))


def series(result: Result, name: str) -> np.ndarray:
    return np.asarray(result.dataset[f"rotor_contact.{name}"].values, np.float64)


def largest(result: Result, name: str) -> float:
    return float(series(result, name).max())


def last_tenths(result: Result, tenths: int = 1) -> np.ndarray:
    """The samples of the last tenths of a second."""
    times = result.dataset["time"].values
    return np.flatnonzero(times > times[-1] - 0.1 * tenths)


def upward_force(result: Result) -> np.ndarray:
    """The vertical part (N) of all contact forces on the rotor; gravity pulls towards -x and -y."""
    total = np.zeros(result.dataset.sizes["time"])
    for site, x, y in (("rb1", "s5", "s6"), ("rb2", "s3", "s4"), ("eb1", "s7", "s8"), ("eb2", "s1", "s2")):
        normal = series(result, x) - series(result, f"{site}.housing_x")
        normal = normal + 1j * (series(result, y) - series(result, f"{site}.housing_y"))
        force = (-series(result, f"{site}.f_n") + 1j * series(result, f"{site}.f_t")) * normal / np.abs(normal)
        total += (force.real + force.imag) / math.sqrt(2.0)
    return total


def touchdown(result: Result) -> dict:
    return result.summary.as_dict()["touchdown"]


@all_scenarios
def test_energy_balances_through_the_whole_touchdown(run: Run, name: str) -> None:
    result = run(name)
    assert result.outcome.failure is None
    assert result.summary.energy_balance is not None
    assert result.summary.energy_balance < 1e-6


def test_rotor_without_power_falls_freely_through_the_clearance(run: Run) -> None:
    """In sqrt(2 c/g) = 12.4 ms, but for the bent shaft, which straightens, and the currents' last milliseconds."""
    result = touchdown(run("drop"))
    assert result["first_impacts"][0]["after_s"] == pytest.approx(math.sqrt(2.0 * CLEARANCE / 9.81), rel=0.1)
    assert all(drop == pytest.approx(1e3 * CLEARANCE, rel=0.01) for drop in result["drop_mm"].values())


def test_rotor_rubbing_at_the_bottom_is_braked_without_whirl(run: Run) -> None:
    """J Omega' = -mu R sum(N), 7 rad/s in a second."""
    result = run("drop")
    assert all(site["whirl"] == "none" and site["rolling_s"] == 0.0 for site in touchdown(result)["retainers"].values())
    at, speed, times = last_tenths(result, 3), series(result, "speed"), result.dataset["time"].values
    slope = (speed[at[-1]] - speed[at[0]]) / (times[at[-1]] - times[at[0]])
    force = sum(series(result, f"{site}.f_n") for site in SITES)[at].mean()
    assert slope == pytest.approx(-0.12 * 0.025 * force / INERTIA, rel=0.02)
    assert slope == pytest.approx(-7.0, abs=0.3)


@pytest.mark.parametrize("name", ["drop", "drop_mount"])
def test_contact_forces_carry_the_weight_once_the_drop_has_settled(run: Run, name: str) -> None:
    result = run(name)
    at = last_tenths(result, 3)
    assert upward_force(result)[at].mean() == pytest.approx(WEIGHT, rel=0.01)


def test_plain_rings_slide_and_races_follow_the_rotor(run: Run) -> None:
    """The race is up to speed within a few J_r omega/(mu N (R + c)), and its retainer takes a fiftieth of the heat."""
    plain, race = run("drop_no_race"), run("drop_race")
    for site in RETAINERS:
        assert touchdown(plain)["retainers"][site]["rolling_s"] == 0.0
        assert touchdown(race)["retainers"][site]["rolling_s"] > 0.3
        assert touchdown(race)["retainers"][site]["race_spin_up_s"] < 0.05
        assert series(race, f"{site}.race_speed")[-1] == pytest.approx(250.0, abs=10.0)
        assert touchdown(race)["retainers"][site]["heat_J"] < 0.1 * touchdown(plain)["retainers"][site]["heat_J"]
    assert series(plain, "speed")[-1] < series(race, "speed")[-1]


def test_soft_mounts_halve_the_force_of_the_first_impacts(run: Run) -> None:
    stiff, soft = run("drop"), run("drop_mount")
    for site in RETAINERS:
        assert largest(soft, f"{site}.f_n") < 0.5 * largest(stiff, f"{site}.f_n")
        assert np.hypot(series(soft, f"{site}.housing_x"), series(soft, f"{site}.housing_y")).max() > 0.05e-3


@pytest.mark.slow
def test_friction_of_dry_steel_makes_the_rotor_whirl_backward_and_roll(run: Run) -> None:
    """Rolling has the whirl speed -R/c Omega, a thousand times the spin's; the spin pays for the shaft's bending."""
    result = run("drop_whirl")
    for site in RETAINERS:
        assert touchdown(result)["retainers"][site]["whirl"] == "backward"
        rolling = series(result, f"{site}.mode") == 2
        whirl, speed = series(result, f"{site}.whirl_speed")[rolling], series(result, "speed")[rolling]
        np.testing.assert_allclose(whirl, -0.025 / CLEARANCE * speed, rtol=1e-3)
    assert result.summary.rolling_from is not None
    assert result.summary.rolling_from < 3.0
    assert series(result, "speed")[-1] < 100.0


def test_rotor_is_lifted_off_its_retainers_when_power_returns(run: Run) -> None:
    result = run("relevitation")
    assert result.summary.recovery == "recovered"
    assert 0.5 < result.summary.last_contact * 2.0 * math.pi / 260.0 < 0.6
    assert all(radius < 0.05 for radius in result.summary.orbit_after.values())


@pytest.mark.slow
def test_rolac_lowers_the_vibration_after_relevitation_below_that_of_pid(run: Run) -> None:
    """All sensors together; the journals themselves move more, as ROLAC weighs them like the ends."""
    alone, helped = run("relevitation", 2.0), run("relevitation_rolac")
    assert helped.summary.recovery == "recovered"
    vibration = [float(r.dataset["rolac_controller.harmonic1.displacement"].values[-1]) for r in (alone, helped)]
    assert vibration[1] < 0.9 * vibration[0]


@pytest.mark.parametrize("name", ["one_axis_lost", "amplifier_lost"])
def test_loss_of_an_axis_lowers_that_end_onto_its_bush(run: Run, name: str) -> None:
    result = run(name)
    at = last_tenths(result)
    assert series(result, "eb1.f_n")[at].mean() == pytest.approx(205.0, abs=30.0)
    assert np.all(series(result, "eb1.mode")[at] == 1)
    assert np.all(series(result, "rb1.mode")[at] == 0)
    assert largest(result, "rb2.f_n") == 0.0
    assert -CLEARANCE < series(result, "mb1.x")[at].mean() < -0.5e-3
    assert abs(series(result, "mb1.y")[at].mean()) < 0.15e-3


def test_failed_sensor_pulls_the_rotor_up_against_the_retainer(run: Run) -> None:
    result = run("sensor_lost")
    at = last_tenths(result)
    assert series(result, "mb1.x")[at].mean() == pytest.approx(CLEARANCE, rel=0.01)
    assert series(result, "rb1.f_n")[at].mean() == pytest.approx(1000.0, rel=0.2)
    assert np.all(series(result, "rb1.mode")[at] == 1)
    assert largest(result, "rb2.f_n") == 0.0


def test_rotor_is_free_again_soon_after_a_shock_of_the_base(run: Run) -> None:
    result = run("base_shock")
    assert all(largest(result, f"{site}.f_n") > 1000.0 for site in SITES)
    assert result.summary.recovery == "recovered"
    assert result.summary.last_contact < 2.0
    assert all(radius < 0.05 for radius in result.summary.orbit_after.values())


def test_rotor_rubs_forward_on_its_bush_after_the_loss_of_a_blade(run: Run) -> None:
    result = run("blade_loss")
    at = last_tenths(result)
    assert series(result, "eb1.f_n")[at].mean() == pytest.approx(2200.0, rel=0.15)
    assert series(result, "eb1.whirl_speed")[at].mean() == pytest.approx(series(result, "speed")[at].mean(), rel=0.02)
    assert all(largest(result, f"{site}.f_n") == 0.0 for site in RETAINERS)


@pytest.mark.slow
def test_spin_becomes_heat_until_the_rotor_comes_to_rest(run: Run) -> None:
    """J Omega^2/2 = 13.9 kJ; changes of 1 % of gains, clearances, unbalances and friction give 35.5 to 36.7 s."""
    result = run("drop_run_down", 40.0)
    assert result.outcome.status == "stopped"
    assert result.outcome.time == pytest.approx(36.1, abs=0.8)
    heat = result.summary.energy
    assert heat is not None
    assert heat["friction"] + heat["impact"] + heat["damping"] == pytest.approx(0.5 * INERTIA * 260.0**2, rel=1e-3)
    assert result.summary.energy_balance < 1e-6
