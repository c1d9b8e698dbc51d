"""The expander with a linear controller, a component like any other in runs and sweeps."""

import numpy as np
import pytest
from strange_machine import LEVITATION

import amb_cosim
from amb_analysis.machine.channels import place_of
from amb_analysis.machine.frequency_response import Structure, frequency_response
from amb_analysis.machine.machine import machine_of
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task
from tests.support.messages import raises_naming

H = 50e-6
BEARINGS = ("north", "guide", "south")
SENSORS = [f"{place}_{direction}" for place in BEARINGS for direction in ("east", "up")]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in BEARINGS for axis in "xy"]
SHOWN = [f"rotor_contact.{bearing}.{axis}" for bearing in BEARINGS for axis in "xy"]
CLEARANCE = 1e-4


def short():
    return Scenario.load(LEVITATION).changed(settle_cycles=0, end_cycle=4)


def under_matrices(scenario, folder, settings=None):
    """A scenario under its PID as matrices: i = -((K_b + K_s) x + C_b (x - x_before)/h)/K_i."""
    prepared = prepare_run(scenario, settings)
    values = prepared.all_parameters()["rolac_controller"]
    k_b, k_s, c_b, k_i, low, high = (
        np.array([values[f"{demand.replace('.i_', f'.{name}_')}"] for demand in DEMANDS])
        for name in ("k_b", "k_s", "c_b", "k_i", "i_min", "i_max")
    )
    k, c, eye = np.diag((k_b + k_s) / k_i), np.diag(c_b / H / k_i), np.eye(6)
    limits = list(zip(low, high, strict=True))
    controller = amb_cosim.linear_controller(
        (0.0 * eye, eye, c, -(k + c)), SENSORS, DEMANDS, H, sampled_arrays=True, limits=limits
    )
    return scenario.changed(fmu={"rolac_controller": str(controller.save(folder / "pid.mat"))})


@pytest.fixture(scope="module")
def levitation(tmp_path_factory):
    """The first cycles."""
    return under_matrices(short(), tmp_path_factory.mktemp("controller"))


def displacements(result):
    return np.array([result.signals[name].values for name in SHOWN])


def test_linear_controller_gives_the_results_of_the_pid(levitation):
    runs = [displacements(amb_cosim.run(scenario, progress=False)) for scenario in (levitation, short())]
    assert np.abs(runs[1]).max() > 1e-3 * CLEARANCE
    np.testing.assert_allclose(*runs, rtol=0.0, atol=1e-12 * CLEARANCE)


def test_limit_cycle_between_its_limits_is_unstable_as_under_the_pid(tmp_path):
    """With much damping for its samples the PID swings between its limits; the amplifiers themselves reach none."""
    scenario = Scenario.load(LEVITATION).changed(event=[], end_cycle=20, settle_cycles=120)
    fast = under_matrices(scenario, tmp_path, {"rolac_controller.*.c_b_?": 8200.0})
    result = amb_cosim.run(fast, progress=False)
    assert result.dataset["rolac_controller.demand_limited"].values.mean() > 0.5
    assert result.summary.recovery == "unstable"


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 1.7])
def test_response_of_a_demand_has_its_whole_delay(levitation, delay):
    """i/x = -((K_b + K_s) + C_b (1 - 1/z)/h)/K_i exp(-j omega d h) of the demand that appears after d samples."""
    settings = {"rolac_controller.delay": delay}
    machine = machine_of(prepare_run(levitation, settings))
    law = machine_of(prepare_run(short())).parameters["rolac_controller"]
    frequencies = np.geomspace(5.0, 2000.0, 20)
    demand, read = (
        place_of(name, unit, machine.rotor, is_input=False) for name, unit in ((DEMANDS[0], "A"), (SENSORS[0], "m"))
    )
    force = place_of("turbine.f_x", "N", machine.rotor, is_input=True)
    structure = Structure(machine.rotor, "closed", machine.Omega, machine)
    current, x = frequency_response(structure, [force], [demand, read], frequencies)[:, :, 0].T
    k_b, k_s, c_b, k_i = (law[f"north.{name}_x"] for name in ("k_b", "k_s", "c_b", "k_i"))
    shift = np.exp(-2j * np.pi * frequencies * H)
    expected = -(k_b + k_s + c_b * (1.0 - shift) / H) / k_i * shift**delay
    np.testing.assert_allclose(current / x, expected, rtol=1e-9)


def test_sweep_varies_the_gain_of_its_demands(levitation):
    """A worker reuses its instances for successive points; the first point repeated gives the same."""
    runner = Runner(Task(levitation))
    points = [runner.run(n, {"rolac_controller.*.gain": gain}) for n, gain in enumerate((1.0, 1.3, 1.0))]
    runner.close()
    assert {point.outcome for point in points} == {points[0].outcome} != {"failed"}
    assert points[0].metrics == points[2].metrics != points[1].metrics


def test_error_names_a_sensor_that_no_component_has():
    law = amb_cosim.linear_controller(-np.eye(6), [*SENSORS[:5], "elsewhere.x"], DEMANDS, H)
    with raises_naming(ValueError, "rolac_controller.elsewhere.x", "sensor", "must be connected"):
        prepare_run(short().changed(fmu={"rolac_controller": law}))
