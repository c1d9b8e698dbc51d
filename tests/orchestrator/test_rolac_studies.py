"""Studies of synchronous control: receptance, test force, H and recovery; their results, files and errors."""

import json

import numpy as np
import pytest
from pump import LEVITATED, sensors
from rig import LOOP

from amb_cosim import studies
from bath_thesis.studies import contact_recovery, recovery_trials
from bath_thesis.studies.h_interpolation import InverseReceptance, interpolated
from rotor_analysis.receptance import receptance
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names

S5, S3 = 4, 2  # sensors in x at MB1 and MB2
MB1, MB2 = 0, 2  # forces in x


def matrices(parts: dict) -> np.ndarray:
    return np.array(parts["real"]) + 1j * np.array(parts["imaginary"])


def responses(k_b: str = "1e6 N/m", c_b: str = "5000 N.s/m") -> np.ndarray:
    return studies.receptance(k_b=k_b, c_b=c_b).receptance


@pytest.mark.parametrize("k_b", [1e6, 2e6])
def test_slow_force_at_a_bearing_deflects_only_that_bearing(k_b):
    """Two bearings support the rotor statically determinately, so that a force at one is carried by that one."""
    slow = responses(k_b=f"{k_b} N/m")[0]
    assert slow[[S5, S3], [MB1, MB2]].real == pytest.approx(1.0 / k_b, rel=0.04)
    assert np.abs(slow[[S3, S5], [MB1, MB2]]).max() < 0.01 / k_b


def test_largest_receptance_does_not_depend_on_the_range_of_speeds():
    """Weak damping makes a peak narrower than the spacing of speeds; the wide range has a third of the points there."""
    narrow, wide = (studies.receptance(up_to=f"{top} Hz", c_b="20 N.s/m") for top in (50, 150))
    within = wide.spin_frequencies <= 50.0
    largest = [np.abs(of).max(axis=0) for of in (narrow.receptance, wide.receptance[within])]
    np.testing.assert_allclose(largest[0][[S5, S3], [MB1, MB2]], largest[1][[S5, S3], [MB1, MB2]], rtol=2e-3)


@pytest.mark.parametrize("rotor", ["compressor", "turbo_expander"])
def test_receptance_of_any_number_of_sensors_is_drawn_with_their_names(rotor):
    result = studies.receptance(rotor, up_to="20 Hz")
    sensors = load_rotor(rotor).sensors
    legend = [text.get_text() for text in studies.figure(result).legends[0].get_texts()]
    assert [label.partition(" at ")[0] for label in legend[: len(sensors)]] == [f"{s.x}, {s.y}" for s in sensors]
    assert_names(result, *(f"{sensor.x}, z = " for sensor in sensors))


def test_speeds_of_machines_are_in_rpm():
    """20 and 16 Hz, which their data keep."""
    result = studies.receptance(up_to="20 Hz")
    assert studies.figure(result).axes[-1].get_xlim()[1] == pytest.approx(1200.0)
    assert_names(result, "rpm")
    cell = contact_recovery.RecoveryStatistics(1.0, 2.0, ())
    compared = contact_recovery.ControlComparison("fig5_6", 16.0, 1.2, (7.0,), 60.0, 1, (0.02,), {"PID": (cell,)})
    assert_names(compared, "960 rpm")
    assert "960 rpm" in studies.figure(compared).get_suptitle()


def test_receptance_is_that_of_the_rotor_in_the_file(runner, tmp_path):
    (tmp_path / "pump.toml").write_text(LEVITATED + sensors(1, 1, 4, 4))
    assert runner("study", "receptance", "--rotor", "pump.toml", "-o", "out").exit_code == 0
    data = json.loads((tmp_path / "out" / "receptance.json").read_text())
    assert (data["rotor"], data["planes_z_m"]) == ("pump", [0.0, 0.0, 0.9, 0.9])
    result = matrices(data["receptance_m_per_N"])
    assert result.shape == (len(data["spin_frequencies_hz"]), 8, 4)
    np.testing.assert_allclose(result[:, :2], result[:, 2:4], rtol=1e-12)


@pytest.fixture(scope="module")
def inverse() -> InverseReceptance:
    return studies.h_matrix()


def test_full_step_with_the_exact_h_leaves_no_force(inverse):
    """H R = -I: the force of H opposes the force that causes the vibration."""
    product = inverse.h @ receptance(2.0 * np.pi * inverse.spin_frequencies)
    np.testing.assert_allclose(product, np.broadcast_to(-np.eye(4), product.shape), atol=1e-10)


def test_h_of_the_table_is_exact_only_at_its_speeds(inverse):
    speeds, errors = inverse.spin_frequencies, inverse.tables["thesis"]
    in_table = np.isin(speeds, inverse.table)
    between = (speeds < 35.0) & (np.abs(speeds - inverse.table[:, None]).min(axis=0) > 0.01)
    assert in_table.sum() == 12
    for values in (errors.relative_error, errors.left_by_a_step):
        assert values[in_table].max() < 1e-10
        assert values[between].min() > 1e-5


def test_interpolation_error_falls_with_the_square_of_the_spacing():
    speeds = 2.0 * np.pi * np.linspace(12.0, 20.0, 101)
    exact = interpolated(LOOP, speeds, receptance(speeds), speeds)
    errors = []
    for spacing in (1.0, 0.5):
        table = 2.0 * np.pi * np.arange(12.0, 20.0 + spacing, spacing)
        errors.append(np.abs(interpolated(LOOP, table, receptance(table), speeds) - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_last_unit_in_a_list_of_unbalances_applies_to_all():
    assert contact_recovery.unbalances("24, 8,16 g.m") == pytest.approx([8e-3, 16e-3, 24e-3])
    assert contact_recovery.unbalances("1e1,2E+1g.m") == pytest.approx([10e-3, 20e-3])
    assert contact_recovery.unbalances("8 g.m,0.01 kg.m") == pytest.approx([8e-3, 10e-3])
    assert contact_recovery.unbalances("0.02") == pytest.approx([20e-3])
    assert contact_recovery.unbalances([0.02, "8 g.m"]) == pytest.approx([8e-3, 20e-3])


def test_statistics_count_runs_that_recover_with_or_without_contact(monkeypatch, runner, check_picture, tmp_path):
    """Of four runs one never touches, two are free after 3 and 9 cycles, and one never recovers."""
    last = {5.0: (True, None), 5.25: (True, 8.25), 5.5: (True, 14.5), 5.75: (False, 60.0)}
    row_of = recovery_trials.row_of
    simulated = lambda trials, progress: [row_of(trial, *last[trial.cycle]) for trial in trials]  # noqa: E731
    monkeypatch.setattr(contact_recovery, "simulate_all", simulated)
    result = runner("study", "recovery", "--steps", "8,16 g.m", "--instants", "4", "--alpha", "5", "-o", "out")
    assert result.exit_code == 0, result.output
    assert "75, 3.0" in result.stdout
    data = json.loads((tmp_path / "out" / "recovery.json").read_text())
    check_picture(tmp_path / "out" / "recovery.png")
    assert data["alphas_per_s"] == [5.0]
    assert len(data["controls"]) == 9, "three of six with H of the model and identified"
    cell = data["controls"]["PID + ROLAC, 5 1/s, H identified"][1]
    assert (cell["recovered_share"], cell["median_cycles"]) == (0.75, 3.0)
    assert [run["disturbance_cycle"] for run in cell["runs"]] == list(last)
    assert [run["cycles"] for run in cell["runs"]] == [0.0, 3.0, 9.0, 54.25]
