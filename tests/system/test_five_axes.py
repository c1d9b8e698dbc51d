"""An upright pump on five axes: its thrust magnet carries the weight, and holds the rotor against a process force."""

from functools import cache
from pathlib import Path

import control
import numpy as np
import pytest

import amb_cosim
from amb_analysis.machine.coupled import MachineVariation, coupled_loop
from amb_analysis.machine.machine import machine_of
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.rotor_file import load_rotor

PUMP = Path(__file__).parent / "upright_pump"
WEIGHT = 9.81 * load_rotor(PUMP / "rotor.toml").mass  # N
PUSH = 2.0  # N, of the process
PUSHED = {"label": "push", "time": 0.02, "set": {"rotor_contact": {"thrust.f_process": PUSH}}}
STEP = 50e-6  # s


@cache
def signals_of(tilt):
    """Signals of a run of 0.2 s at a tilt (degrees), with the push from 20 ms on."""
    scenario = load_scenario(str(PUMP / "levitation.toml")).changed(event=[PUSHED], tilt=f"{tilt} deg")
    result = amb_cosim.run(scenario, progress=False)
    assert result.outcome.failure is None, result.outcome.failure
    return {name: result.dataset[name].values for name in result.dataset.data_vars}


def before_push(tilt, name):
    return signals_of(tilt)[name][round(0.01 / STEP)]


@pytest.mark.parametrize("tilt", [90, -90, 30])
def test_the_thrust_magnet_carries_the_weight_along_the_shaft(tilt):
    assert before_push(tilt, "amb_actuator.thrust.f_z") == pytest.approx(WEIGHT * np.sin(np.radians(tilt)), rel=1e-6)
    assert abs(before_push(tilt, "rotor_contact.thrust.z")) < 1e-9


@pytest.mark.parametrize("tilt", [90, 30])
def test_the_bearings_carry_the_weight_across_the_shaft(tilt):
    """It pulls along both axes alike. The whirl of the unbalance has no mean over some turns."""
    turns = slice(round(0.01 / STEP), round(0.02 / STEP))
    for axis in "xy":
        forces = sum(signals_of(tilt)[f"amb_actuator.{bearing}.f_{axis}"] for bearing in ("lower", "upper"))
        expected = WEIGHT * np.cos(np.radians(tilt)) / np.sqrt(2.0)
        assert forces[turns].mean() == pytest.approx(expected, abs=0.01 * WEIGHT)


def test_the_controller_pulls_against_the_push_until_the_rotor_is_back():
    signals = signals_of(90)
    z = signals["rotor_contact.thrust.z"]
    assert z[round(0.021 / STEP)] > 1e-7
    assert abs(z[-1]) < 0.05 * np.max(z)
    assert signals["rolac_controller.thrust.i_z"][-1] < 0.0
    assert signals["amb_actuator.thrust.f_z"][-1] == pytest.approx(WEIGHT - PUSH, rel=1e-3)


def test_the_thrust_magnet_takes_the_rotor_along_with_its_base(tmp_path):
    """The base is lifted with 2 m/s2, from a table whose rows are closer than steps."""
    times = np.arange(0.0, 0.3, 0.02e-3)
    lifted = np.where(times >= 0.01, 2.0, 0.0)
    rows = "\n".join(f"{t:.6f},{a}" for t, a in zip(times, lifted, strict=True))
    (tmp_path / "lift.csv").write_text(f"time (s),rotor_contact.base.a_z (m/s2)\n{rows}\n", encoding="utf-8")
    lift = [{"file": str(tmp_path / "lift.csv")}]
    scenario = load_scenario(str(PUMP / "levitation.toml")).changed(profile=lift)
    signals = amb_cosim.run(scenario, progress=False).dataset
    z, force = (signals[name].values for name in ("rotor_contact.thrust.z", "amb_actuator.thrust.f_z"))
    assert z[round(0.011 / STEP)] < -1e-7  # it is left behind first
    assert force[-1] == pytest.approx(WEIGHT * (1.0 + 2.0 / 9.81), rel=1e-3)


def test_the_linear_model_moves_along_the_shaft_as_the_machine_does():
    scenario = load_scenario(str(PUMP / "levitation.toml"))
    inputs, outputs = ["rotor_contact.thrust.f_process"], ["rotor_contact.thrust.z"]
    loop = amb_cosim.linearise(scenario, inputs=inputs, outputs=outputs)
    first = round(0.02 / STEP)
    z = signals_of(90)["rotor_contact.thrust.z"][first : first + 400]
    times = np.arange(len(z)) * STEP
    expected = control.forced_response(loop, times, np.full(len(z), PUSH)).outputs
    assert np.max(np.abs(z - expected)) < 0.02 * np.max(np.abs(expected))


def test_a_varied_loop_keeps_the_axis_along_the_shaft():
    machine = machine_of(prepare_run(load_scenario(str(PUMP / "levitation.toml"))))
    nominal = machine.loop.poles(0.0).z
    same = coupled_loop(machine, variation=MachineVariation(modes=1.0 + 1e-12)).poles(0.0).z
    assert len(same) == len(nominal)
    np.testing.assert_allclose(np.sort(np.abs(same)), np.sort(np.abs(nominal)), atol=1e-9)
    weaker = coupled_loop(machine, variation=MachineVariation(k_s=0.9)).poles(0.0).z
    assert np.max(np.abs(np.sort(np.abs(weaker)) - np.sort(np.abs(nominal)))) > 1e-5


@pytest.fixture(scope="module")
def landing():
    """The pump without power: it falls onto its seat, whose race follows it."""
    result = amb_cosim.run(str(PUMP / "landing.toml"), progress=False)
    assert result.outcome.failure is None, result.outcome.failure
    return result


def test_the_pump_falls_onto_its_seat_and_stands_there(landing):
    signals = landing.dataset
    mode, time = signals["rotor_contact.seat.mode"].values, signals["time"].values
    fall = np.sqrt(2.0 * 0.25e-3 / 9.81)  # s; the current decays within the first millisecond
    assert fall < time[np.argmax(mode > 0.0)] < fall + 1e-3
    assert signals["rotor_contact.seat.f_n"].values[-1] == pytest.approx(WEIGHT, rel=1e-4)
    assert not signals["rotor_contact.stop.mode"].values.any()
    assert signals["rotor_contact.contact_state"].values[-1] == 1.0  # that of the lower bearing
    speed, race = (signals[f"rotor_contact.{name}"].values[-1] for name in ("speed", "catch_lower.race_speed"))
    assert race == pytest.approx(speed, rel=1e-4)
    balance = signals["rotor_contact.energy.balance"].values
    assert np.max(np.abs(balance)) < 1e-6 * signals["rotor_contact.energy.dissipated"].values[-1]


def test_the_summary_names_the_face_on_which_the_rotor_stands(landing):
    summary = landing.summary
    verdict = summary.verdict
    assert verdict.word == "landed"
    assert "seat" in str(verdict)
    assert 600.0 < summary.averaged_contact_force["seat"] < summary.peak_contact_force["seat"] < 1100.0
    face = summary.touchdown.retainers["seat"]
    race = 0.5 * 6e-6 * landing.dataset["rotor_contact.catch_lower.race_speed"].values[-1] ** 2
    slid = landing.dataset["rotor_contact.seat.heat"].values[-1]  # without the drag of the race
    assert slid == pytest.approx(race, rel=0.1)  # friction on a race takes as much as the race gains
    assert face.heat == pytest.approx(summary.energy["friction"] + summary.energy["impact"], rel=0.01)
    assert face.temperature > 293.15
    assert all(mm is None for mm in summary.touchdown.drop.values())  # nothing falls across an upright shaft


def test_figures_of_a_landing_show_the_gaps_along_the_shaft(landing):
    from amb_cosim.results.plots import chosen, figure

    assert {"touchdown", "contact"} <= set(chosen(landing.dataset))
    titles = [panel.get_title("left") for panel in figure(landing.dataset, "touchdown").axes]
    assert any("along the shaft" in title for title in titles)
    assert not any("gravity" in title for title in titles)
