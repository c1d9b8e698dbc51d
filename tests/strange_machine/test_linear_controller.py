"""The expander under a linear controller: in runs, sweeps, archives and assemblies it is a component as any other."""

import numpy as np
import pytest
from strange_machine import LEVITATION

import amb_cosim
from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task

H = 50e-6
BEARINGS = ("north", "guide", "south")
SENSORS = [f"{place}_{direction}" for place in BEARINGS for direction in ("east", "up")]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in BEARINGS for axis in "xy"]
SHOWN = [f"rotor_contact.{bearing}.{axis}" for bearing in BEARINGS for axis in "xy"]
CLEARANCE = 1e-4


def short():
    return Scenario.load(LEVITATION).changed(settle_cycles=0, end_cycle=4)


@pytest.fixture(scope="module")
def levitation(tmp_path_factory):
    """The first cycles, under the scenario's PID as matrices: i = -((K_b + K_s) x + C_b (x - x_before)/h)/K_i."""
    planned = plan_run(short())
    values = planned.plan.all_parameters(planned.interfaces)["rolac_controller"]
    k_b, k_s, c_b, k_i, low, high = (
        np.array([values[f"{demand.replace('.i_', f'.{name}_')}"] for demand in DEMANDS])
        for name in ("k_b", "k_s", "c_b", "k_i", "i_min", "i_max")
    )
    k, c, eye = np.diag((k_b + k_s) / k_i), np.diag(c_b / H / k_i), np.eye(6)
    limits = list(zip(low, high, strict=True))
    controller = amb_cosim.linear_controller(
        (0.0 * eye, eye, c, -(k + c)), SENSORS, DEMANDS, H, sampled_arrays=True, limits=limits
    )
    path = controller.save(tmp_path_factory.mktemp("controller") / "pid.mat")
    return short().changed(fmu={"rolac_controller": str(path)})


def displacements(result):
    return np.array([result.signals[name].values for name in SHOWN])


def test_it_gives_the_results_of_the_pid(levitation):
    runs = [displacements(amb_cosim.run(scenario, progress=False)) for scenario in (levitation, short())]
    assert np.abs(runs[1]).max() > 1e-3 * CLEARANCE
    np.testing.assert_allclose(*runs, rtol=0.0, atol=1e-12 * CLEARANCE)


def test_sweep_varies_the_gain_of_its_demands(levitation):
    """An instance of a worker runs one point after the other; the first of them twice is the same."""
    runner = Runner(Task(levitation))
    result = [runner.run(n, {"rolac_controller.*.gain": gain}) for n, gain in enumerate((1.0, 1.3, 1.0))]
    runner.close()
    assert {point.outcome for point in result} == {result[0].outcome} != {"failed"}
    assert result[0].metrics == result[2].metrics != result[1].metrics


@pytest.mark.slow
def test_archive_of_it_is_the_same_run(levitation, tmp_path):
    path = amb_cosim.export_ssp(levitation, tmp_path / "expander.ssp") or tmp_path / "expander.ssp"
    runs = [amb_cosim.run(levitation, progress=False), amb_cosim.simulate(path)]
    for name in SHOWN:
        np.testing.assert_array_equal(*(run.signals[name].values for run in runs))


def test_model_of_the_loop_has_it_and_it_is_stable(levitation):
    loop = amb_cosim.linearise(levitation, inputs=["rotor_contact.turbine.f_x"], outputs=SHOWN)
    assert loop.dt == pytest.approx(H)
    assert 0.9 < abs(loop.poles()).max() < 1.0
