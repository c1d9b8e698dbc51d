"""The studies of the levitated rig on the command line: what they print and write, and what they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread


def check_picture(path: Path) -> None:
    picture = imread(path)[:, :, :3]
    assert min(picture.shape[:2]) > 600
    assert (picture.min(axis=2) < 0.99).mean() > 0.01


@pytest.mark.slow
def test_linearisation_writes_its_figure_and_its_numbers(runner, tmp_path):
    result = runner("study", "linearisation")
    assert result.exit_code == 0, result.output
    assert "2376.96 N/mm, 563.15 N/A" in result.stdout
    folder = tmp_path / "results" / "study_linearisation"
    check_picture(folder / "linearisation.png")
    data = json.loads((folder / "linearisation.json").read_text())
    chart = {name: np.array(values) for name, values in data["map"].items()}
    x, i_c = np.meshgrid(chart["x_m"], chart["i_c_A"])
    assert x.shape == chart["k_s"].shape == chart["k_i"].shape == chart["linear_error"].shape
    x_low, x_high = data["linear_range"]["x_m"]
    i_low, i_high = data["linear_range"]["i_c_A"]
    centred = chart["linear_error"][:, np.argmin(np.abs(chart["x_m"]))]
    assert np.interp([i_low, i_high], chart["i_c_A"], centred) == pytest.approx(0.05, abs=0.005)
    small = (np.abs(x) < 0.2 * min(-x_low, x_high)) & (np.abs(i_c) < 0.2 * min(-i_low, i_high))
    assert chart["linear_error"][small].max() < 0.05
    assert chart["k_s"][small] == pytest.approx(data["k_s_N_per_m"], rel=0.15)


@pytest.mark.slow
def test_more_bias_stiffens_the_bearing_and_speeds_it_up(runner, tmp_path):
    found = []
    for bias in ("3 A", "4.5 A"):
        assert runner("study", "linearisation", "--bias-current", bias, "-o", "out").exit_code == 0
        found.append(json.loads((tmp_path / "out" / "linearisation.json").read_text()))
    weak, strong = found
    assert weak["k_i_N_per_A"] < strong["k_i_N_per_A"]
    assert weak["k_s_N_per_m"] < strong["k_s_N_per_m"]
    assert max(weak["slew_rate_N_per_s"]) < min(strong["slew_rate_N_per_s"])


@pytest.mark.slow
def test_control_force_against_a_load_shrinks_to_zero(runner, tmp_path):
    runner("study", "linearisation", "-o", "out")
    load = json.loads((tmp_path / "out" / "linearisation.json").read_text())["load"]
    up, down = np.array(load["up_N"]), np.array(load["down_N"])
    assert up[0] == pytest.approx(down[0])
    assert np.all(np.diff(up) < 0.0)
    assert up[-1] < 0.1 * up[0]
    assert load["own"]["static_load_N"] == pytest.approx(321.0, abs=0.1)


BAD = {
    "no bias": (["linearisation", "--bias-current", "0"], "bias-current = 0 A is not allowed; it must be > 0 A"),
    "bias in metres": (["linearisation", "--bias-current", "3 m"], "'3 m' has unit m, which cannot be converted to A"),
    "static current beyond the coils": (
        ["linearisation", "--static-current", "9 A"],
        "bias_current = 4.43 A plus static_current = 9 A is not allowed",
    ),
    "speed that is no number": (["sensitivity", "--speed", "fast"], "speed = 'fast' is no number"),
    "no speed": (["sensitivity", "--speed", "0"], "Omega = 0 rad/s is not allowed; it must be > 0 rad/s"),
    "no sample time": (["sensitivity", "--sample-time", "0"], "sample-time = 0 s is not allowed"),
    "slow sampling": (["sensitivity", "--sample-time", "1 ms"], "the loop is not stable: a vibration of"),
    "amplifiers and delay": (["sensitivity", "--amplifier", "--delay"], "the loop is not stable: a vibration of"),
    "no such parameter": (
        ["sensitivity", "--set", "rolac_controller.*.c_d_?=1"],
        "rolac_controller has no parameter or input '*.c_d_?'",
    ),
    "another sample time": (
        ["sensitivity", "--set", "rolac_controller.sample_time=500 us"],
        "rolac_controller.sample_time cannot be set here; sample-time sets it",
    ),
    "unbalance": (
        ["sensitivity", "--set", "rotor_contact.d1.u=1 g.m"],
        "rotor_contact.d1.u cannot be set here; only parameters can",
    ),
    "no gain": (
        ["sensitivity", "--set", "amb_actuator.mb1.amplifier_gain_x=0"],
        "amplifier_gain = 0 A/V is not allowed; it must not be 0",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_ends_with_one_message_and_nothing_written(refuses, case):
    arguments, expected = BAD[case]
    refuses(expected, "study", *arguments)


def test_studies_of_the_rig_take_no_rotor_file(runner):
    result = runner("study", "linearisation", "--rotor", "pump.toml")
    assert result.exit_code == 2
    assert "No such option" in result.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "printed"),
    [("sensitivity", "zone D (ISO 14839-3: A below 3, B below 4, C below 5)"), ("coupling", "nonlinear law")],
)
def test_studies_by_co_simulation_write_figure_and_data(cosim, tmp_path, name, printed):
    process = cosim("study", name)
    assert process.returncode == 0, process.stderr
    assert printed in process.stdout
    folder = tmp_path / "results" / f"study_{name}"
    check_picture(folder / f"{name}.png")
    json.loads((folder / f"{name}.json").read_text(), parse_constant=pytest.fail)
