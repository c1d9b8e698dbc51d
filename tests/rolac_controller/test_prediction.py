"""Displacements and angle that the controller looks ahead to, for a master that passes them on late."""

import math

import numpy as np
import pytest
from rig import CONTROLLER, pack

T = 250e-6
OMEGA = 200.0
SLOPES = 1e-3 * np.linspace(-3.0, 5.0, 8)  # m/s


def drive(b, displacements, steps, h, ahead=0.0):
    """Outputs after each step of `h` (s), for displacements and an angle of a time that is `ahead` (s)."""
    rows = []
    for n in range(steps):
        t = n * h + ahead
        b.sense(displacements(t))
        b["theta"] = OMEGA * t % (2.0 * math.pi)
        b.instance.step(n * h, h)
        rows.append(b.instance.outputs.copy())
    return np.array(rows)


def ramp(t):
    return 1e-5 + SLOPES * t


def turning(t):
    return 1e-4 * np.cos(OMEGA * t + np.arange(8.0))


@pytest.mark.parametrize("parts", [1, 4])
def test_linear_motion_is_predicted_without_error(bench, parts):
    h = T / parts
    foreseen = drive(bench(Omega=OMEGA, prediction_time=2 * h), ramp, 30 * parts, h)
    exact = drive(bench(Omega=OMEGA), ramp, 30 * parts, h, ahead=2 * h)
    currents = [CONTROLLER.interface.index("output", f"mb{k}.i_{a}") for k in (1, 2) for a in "xy"]
    difference = np.abs(foreseen - exact)[2 * parts :, currents]  # the first two samples have no step before
    assert difference.max() < 1e-12 * np.abs(exact[:, currents]).max()
    assert np.abs(np.diff(exact[::parts, currents], axis=0)).min() > 0.0


def test_error_of_the_prediction_is_that_of_the_curvature(bench):
    """With C_b = 0 the current shows the displacement that the controller counts with."""
    curvature, h, n = 2.0, T / 5, 50  # m/s2
    b = bench(prediction_time=3e-4, mb1__c_b_x=0.0)
    drive(b, lambda t: np.full(8, 0.5 * curvature * t * t), n + 1, h)
    t = n * h
    result = -b["mb1.i_x"] * b["mb1.k_i_x"] / (b["mb1.k_b_x"] + b["mb1.k_s_x"])
    assert result - 0.5 * curvature * (t + 3e-4) ** 2 == pytest.approx(-0.5 * curvature * 3e-4 * (3e-4 + h), rel=1e-9)


def test_the_synchronous_force_is_predicted(bench, receptance):
    """After some turns of a steady orbit, the forces equal those of a controller with the future displacement."""
    h, p = T / 5, 0.4 * T
    table = pack([50.0, 400.0], [receptance, receptance])
    result = []
    for values, ahead in ((p, 0.0), (0.0, p)):
        b = bench(table, Omega=OMEGA, prediction_time=values, rolac_enable=1.0)
        drive(b, turning, 5 * 400, h, ahead)
        assert b["rolac_active"] == 1.0
        result.append([b["mb1.u_x"], b["mb1.u_phase_x"], b["mb1.i_x"]])
    np.testing.assert_allclose(result[0], result[1], rtol=2e-3)


def test_noise_and_faults_of_the_sensors_are_not_extrapolated(bench):
    """The spread of the currents is that of a controller without prediction."""
    spreads = []
    for p in (0.0, T):
        b = bench(prediction_time=p, mb1__c_b_x=0.0, s5__fault_noise=1e-6, s5__fault_offset=1e-5)
        rows = drive(b, lambda t: np.zeros(8), 400, T)
        column = rows[:, CONTROLLER.interface.index("output", "mb1.i_x")]
        spreads.append((column.mean(), column.std()))
    assert spreads[0] == spreads[1]
    assert spreads[0][1] > 0.0
