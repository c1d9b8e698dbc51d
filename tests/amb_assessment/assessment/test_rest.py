"""What becomes of a rotor after its power is lost."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amb_assessment.assessment.analyses import rest
from amb_assessment.assessment.analyses.rest import Outlook
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.coast_down import coast_down, temperatures

TIMES = np.linspace(0.0, 1.0, 201)
J = 0.5  # kg m^2
EXPANDER = Path(__file__).parents[2] / "strange_machine" / "machine.toml"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_constant_friction_torque_stops_the_spin_after_j_omega_over_m(sense):
    """J Omega' = -M: t = J Omega/M, for either sense of rotation; the start of the run does not count."""
    speeds = 400.0 - 8.0 * TIMES
    speeds[:20] += 5.0
    on = coast_down(TIMES, sense * speeds, J, 0.0)
    assert on.time == pytest.approx(50.0)
    assert on.heat == pytest.approx(0.5 * J * 392.0**2)


def test_gas_and_friction_share_the_energy_of_the_spin():
    """J Omega' = -M - d Omega, integrated to standstill; the retainers take the heat that the gas does not."""
    M, d = 4.0, 0.1

    def still(t, y):
        return y[0]

    still.terminal = True
    result = solve_ivp(
        lambda t, y: [-(M + d * y[0]) / J, d * y[0] ** 2],
        (0.0, 100.0),
        [400.0, 0.0],
        events=still,
        dense_output=True,
        rtol=1e-10,
        atol=1e-10,
    )
    on = coast_down(TIMES, result.sol(TIMES)[0], J, d)
    at_end, of_gas = result.sol(1.0)
    assert on.time == pytest.approx(result.t[-1], rel=1e-6)
    assert on.heat == pytest.approx(0.5 * J * at_end**2 - (result.y[1, -1] - of_gas), rel=1e-6)


@pytest.mark.slow
def test_displacement_of_a_thinned_landing_is_drawn_over_the_time_of_its_steps(monkeypatch):
    """The record of a long run is thinned, but displacements remain at every step; both curves end with the run."""
    monkeypatch.setattr(rest, "FIRST", 0.05)
    monkeypatch.setattr(rest, "LONGEST", 0.05)
    monkeypatch.setattr(rest, "RECORDS", 100)
    monkeypatch.setattr(rest, "_convergence", lambda *_: [])
    displacement, speed = rest.result_of(assessed_machine_of(load_machine(EXPANDER))).panels
    assert len(speed.curves[0].x) < 120
    for curve in displacement.curves:
        assert len(curve.x) == len(curve.y) > 150
        assert curve.x[-1] == pytest.approx(speed.curves[0].x[-1])


def landed(transfer, *, races=(2400.0, 1200.0), slope=0.25):
    """A coast-down with rotating races, and their heat and temperatures, 200 s long; the races warm alike."""
    times = np.linspace(0.0, 200.0, 401)
    speeds = 2500.0 - slope * times
    lost = 0.5 * J * (speeds[0] ** 2 - speeds**2) - 0.5 * 1e-4 * sum(race**2 for race in races)
    values = {"time": times, "rotor_contact.speed": speeds}
    p = {"spin.inertia": J, "spin.drag": 0.0, "ambient_temperature": 293.0}
    sites = {}
    for site, race in zip(("a", "b"), races, strict=True):
        values |= {
            f"rotor_contact.{site}.race_speed": np.full(401, race),
            f"rotor_contact.{site}.heat": 0.5 * lost,
            f"rotor_contact.{site}.temperature": np.full(401, 300.0),
        }
        p |= {f"{site}.race_inertia": 1e-4, f"{site}.heat_capacity": 60.0, f"{site}.heat_transfer": transfer}
        sites[site] = SimpleNamespace(heat=0.5 * lost[-1], temperature=300.0)
    touchdown = SimpleNamespace(retainers=sites, rest_after=1.0, rocks_within=None, slow_after=None)
    subject = SimpleNamespace(parameters={"rotor_contact": p}, rotor=SimpleNamespace(faces=()))
    run = SimpleNamespace(signals={name: SimpleNamespace(values=value) for name, value in values.items()})
    return {item.quantity: item for item in rest._to_rest(subject, run, touchdown)}


@pytest.mark.parametrize("races", [(2400.0, 1200.0), (0.0, 0.0)])
def test_heat_to_standstill_is_the_energy_of_the_spin_without_gas(races):
    """The rotor's energy at the loss of power; the races got theirs from it and dissipate it in the retainers."""
    assert landed(2.0, races=races)["heat_to_standstill"].value == pytest.approx(0.5 * J * 2500.0**2, rel=1e-6)


def test_retainers_with_heat_transfer_stay_near_their_steady_temperature():
    """J a Omega/2 of a retainer over h = 1 W/K, for standstill after 9800 s and C/h = 60 s."""
    found, steady = landed(1.0)["temperature_to_standstill"], 0.5 * J * 0.25 * 2450.0
    assert 0.9 * steady < found.value - 293.0 < steady
    assert "at most" not in found.where


def test_retainers_without_heat_transfer_have_an_upper_bound():
    """All remaining heat stays in two capacities of 60 J/K; the race of a has more energy than that of b."""
    found = landed(0.0)["temperature_to_standstill"]
    remaining = 0.25 * J * 2450.0**2 + 0.5 * 1e-4 * 2400.0**2
    assert found.value == pytest.approx(300.0 + remaining / 60.0, rel=1e-6)
    assert "at most" in found.where


def test_temperatures_follow_the_heat_flow_with_a_lag():
    """C T' = 48 W - h (T - T_a): 48/h (1 - exp(-h t/C))."""
    times = np.linspace(0.0, 100.0, 11)
    found = temperatures(times, 48.0 * times, 293.0, capacity=60.0, transfer=2.0, ambient=293.0)
    assert found == pytest.approx(293.0 + 24.0 * -np.expm1(-2.0 * times / 60.0))


@pytest.mark.parametrize("gain", [0.0, 3.0])
def test_a_spin_without_deceleration_never_stops(gain):
    assert coast_down(TIMES, 400.0 + gain * TIMES, J, 0.0) is None
    assert coast_down(TIMES, 400.0 * np.exp(-0.2 * TIMES), J, 0.2 * J) is None


@pytest.mark.parametrize(
    ("before", "after", "same"),
    [
        (Outlook(900.0, 8.0), Outlook(905.0, 7.0), True),
        (Outlook(np.inf, 0.0), Outlook(np.inf, 0.0), True),
        (Outlook(900.0, 8.0), Outlook(950.0, 8.0), False),
        (Outlook(900.0, 8.0), Outlook(np.inf, 8.0), False),
        (Outlook(900.0, 20.0), Outlook(900.0, 6.0), False),
        (Outlook(900.0, 20.0), Outlook(900.0, 0.0), False),
        (Outlook(900.0, None), Outlook(900.0, 8.0), False),
        (Outlook(900.0, 8.0), Outlook(900.0, None), False),
    ],
)
def test_decay_whirl_and_another_slowdown_require_a_longer_landing(before, after, same):
    assert after.is_that_of(before) is same


@pytest.mark.slow
def test_a_longer_landing_confirms_the_predicted_standstill(monkeypatch):
    """An expander that rocks in races with drag, 42 s long."""
    monkeypatch.setattr(rest, "FIRST", 1.0)
    monkeypatch.setattr(rest, "LONGEST", 8.0)
    runs = []
    for tolerance in (rest.SAME_TIME, 0.0):
        monkeypatch.setattr(rest, "SAME_TIME", tolerance)
        (part,) = assess(EXPANDER, only=["rest"]).parts
        assert not part.reason
        runs.append({item.measured.quantity: item.measured for item in part.findings})
    early, late = runs
    assert early["rest_time"].value <= 4.0
    assert late["rest_time"].value == 8.0
    for quantity in ("standstill_time", "heat_to_standstill"):
        assert early[quantity].value == pytest.approx(late[quantity].value, rel=0.01)


@pytest.mark.parametrize("state", ["saved", None])
def test_a_landing_lasts_as_long_if_a_component_cannot_save_its_state(state, monkeypatch):
    """Without a saved state, a longer run begins anew. It does not last longer, which would change heat and times."""
    runs = []

    def simulate(*_, end_time, start, goes_on):
        runs.append((end_time, start))

    for name, value in (
        ("simulate", simulate),
        ("longest", lambda *_: 40.0),
        ("end_of", lambda _: state),
        ("_without_drive", lambda *_: {}),
        ("_outlook", lambda *_: Outlook(900.0, 8.0)),
    ):
        monkeypatch.setattr(rest, name, value)
    rest._fall(None, 100.0, {}, {})
    assert runs == [(5.0, None), (10.0, state)]


@pytest.mark.slow
def test_the_compressor_is_followed_to_standstill_in_its_retainers():
    (part,) = assess("compressor", only=["rest"]).parts
    assert not part.reason
    quantities = {item.measured.quantity: item.measured for item in part.findings}
    assert quantities["standstill_time"].where == "simulated to 1 % of the speed"
    assert 0.0 < quantities["rest_time"].value <= quantities["standstill_time"].value < 20.0
    of_spin = 0.5 * 0.9155 * (9000.0 * np.pi / 30.0) ** 2
    assert 0.01 * of_spin < quantities["retainer_heat"].value < 0.05 * of_spin  # the gas takes the rest
    half = 0.5 * quantities["retainer_heat"].value / 2000.0
    assert quantities["retainer_temperature"].value == pytest.approx(293.15 + half, abs=0.2)
