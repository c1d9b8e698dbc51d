"""Poles of a loop whose rotor file states no damping: what the control cannot reach costs nothing."""

from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear import stability
from amb_analysis.machine.machine import Machine
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from tests.support.independent_loop import independent_loop

SPEED = 900.0  # rad/s
LEAST_CHANGE = 0.02  # 1/s, three times the rounding of the independent loop
ROTOR = """
name = "rod"

[shaft]
youngs_modulus = 1.93e11
density = 7964.0
poissons_ratio = 0.3

[[shaft.sections]]
length = 0.269
diameter = 0.0125

[[bearings]]
name = "left"
z = 0.024

[[bearings]]
name = "right"
z = 0.245

[[sensors]]
name = "probe_left"
z = 0.0028

[[sensors]]
name = "probe_right"
z = 0.2662
"""
CONTROLLER = """
inputs = ["probe_left.x", "probe_left.y", "probe_right.x", "probe_right.y"]
outputs = ["left.i_x", "left.i_y", "right.i_x", "right.i_y"]
sample_time = "20 us"
delay = 0

[[channel]]
from = ["probe_left.x", "probe_left.y", "probe_right.x", "probe_right.y"]
to = ["left.i_x", "left.i_y", "right.i_x", "right.i_y"]
gain = -1
blocks = [
  { type = "pid", kp = "1762.5 A/m", kd = "0.987 A.s/m", roll_off = "3030 rad/s" },
  { type = "low_pass", frequency = "45454 rad/s", order = 1 },
]
"""
SCENARIO = """
rotor = "rotor.toml"
Omega = "9000 rpm"
communication_step = "20 us"
end_time = "0.1 s"
fmu.rolac_controller = "controller.toml"

[parameters.amb_actuator]
force_law = "measured"
amplifier = "dynamic"
"*.k_i_measured_?" = "3.5 N/A"
"*.k_s_measured_?" = "4300 N/m"
"*.bandwidth_?" = "723 Hz"
"""


def levitated(folder: Path, damping: str = "") -> Machine:
    texts = {"rotor.toml": ROTOR + damping, "controller.toml": CONTROLLER, "levitation.toml": SCENARIO}
    for name, text in texts.items():
        (folder / name).write_text(text)
    return Machine(prepare_run(as_scenario(folder / "levitation.toml")))


@pytest.fixture(scope="module")
def undamped(tmp_path_factory) -> Machine:
    return levitated(tmp_path_factory.mktemp("undamped"))


def test_an_undamped_rotor_has_about_as_many_poles_as_one_with_half_a_percent(undamped, tmp_path):
    """All modes of the elements were kept, since their responses have no bound without damping."""
    few = len(levitated(tmp_path, "[damping]\nmodal = 0.005\n").loop.poles(SPEED).z)
    assert few <= len(undamped.loop.poles(SPEED).z) < 2 * few < 4 * len(undamped.rotor.shaft.nodes)


def test_the_rates_of_an_undamped_rotor_are_those_of_all_its_elements(undamped):
    """Of each vibration that the control damps or drives by more than 0.02 1/s."""
    exact, ours = independent_loop(undamped, SPEED), undamped.loop.poles(SPEED).z
    z = exact.closed_poles()
    rates, found = np.log(np.abs(z)) / exact.time, np.log(np.abs(ours)) / exact.time
    reached = (np.abs(rates) > LEAST_CHANGE) & (np.abs(z) > 0.99)
    assert reached.sum() >= 10
    for k in np.flatnonzero(reached):
        nearest = np.abs(np.concatenate([ours, ours.conj()]) - z[k]).argmin() % len(ours)
        assert found[nearest] == pytest.approx(rates[k], rel=1e-3)


def test_each_speed_takes_one_eigenvalue_problem(undamped, monkeypatch):
    """Poles near the unit circle need left eigenvectors, which the same solution gives."""
    count = []

    def counted(solve):
        def call(*arguments, **options):
            count.append(solve.__name__)
            return solve(*arguments, **options)

        return call

    monkeypatch.setattr(stability, "eig", counted(stability.eig))
    for name in ("eig", "eigvals"):
        monkeypatch.setattr(np.linalg, name, counted(getattr(np.linalg, name)))
    for Omega in (500.0, 600.0, 700.0):
        undamped.loop.poles(Omega)
    assert len(count) == 3
