"""The model of the sampled loop: its parts in closed form; other tests compare the whole with identification."""

import math

import numpy as np
import pytest
from rig import given_parameters, identified_receptance
from sampled_loop import controller_response, zoh_response

from amb_analysis.linear.sampled_loop import parameters_of_loop, sensor_response
from rolac_controller import interface
from rolac_controller.control_loop import ControlLoop, SensorPlane
from rolac_controller.parameters import BEARING_K_S

OMEGA, H = 2.0 * math.pi * 16.0, 250e-6


def test_mass_under_a_held_force_obeys_newtons_law_at_samples():
    """x'' = u/m with u held: (h^2/2m) (z + 1)/(z - 1)^2."""
    z = np.exp(1j * OMEGA * H)
    held = zoh_response([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0 / 40.0]], [[1.0, 0.0]], OMEGA, H)
    assert held[0, 0] == pytest.approx(H**2 / 80.0 * (z + 1.0) / (z - 1.0) ** 2, rel=1e-9)


def test_hold_delays_by_half_a_sample():
    held = zoh_response([[0.0, 1.0], [-1e6, -1e3]], [[0.0], [1.0]], [[1.0, 0.0]], OMEGA, H)[0, 0]
    continuous = 1.0 / (1e6 - OMEGA**2 + 1e3j * OMEGA)
    assert held / continuous == pytest.approx(np.exp(-0.5j * OMEGA * H), rel=1e-4)


def test_loop_without_control_and_with_the_ideal_chain_is_the_plant(receptance):
    off = {f"{b}.{name}_{a}": 0.0 for b in ("mb1", "mb2") for a in "xy" for name in ("k_b", "k_s", "c_b")}
    np.testing.assert_allclose(identified_receptance(receptance, OMEGA, off), receptance, rtol=1e-14)


def test_delay_filter_and_scale_change_phase_and_amplitude_of_signals(receptance):
    off = {f"{b}.{name}_{a}": 0.0 for b in ("mb1", "mb2") for a in "xy" for name in ("k_b", "k_s", "c_b")}
    late = identified_receptance(receptance, OMEGA, off | {"chain.preset": 2, "chain.delay": 1})
    np.testing.assert_allclose(late, receptance * np.exp(-1j * OMEGA * H), rtol=1e-13)
    scaled = identified_receptance(receptance, OMEGA, off | {"s2.scale": 1.1})
    np.testing.assert_allclose(scaled[1], 1.1 * receptance[1], rtol=1e-14)


def test_stiff_pid_acts_as_a_spring_of_its_stiffness():
    """A plant much softer than the PID gives 1/C at the bearings' sensors."""
    plant = np.zeros((8, 4), dtype=complex)
    plant[[4, 5, 2, 3], range(4)] = 1.0
    r = identified_receptance(plant, OMEGA)
    c = controller_response(given_parameters({}), OMEGA)[0, 4]
    np.testing.assert_allclose(r[[4, 5, 2, 3], range(4)], 1.0 / c, rtol=1e-6)
    assert c == pytest.approx(1e6 + BEARING_K_S + 5e3j * OMEGA, rel=1e-2)


def test_sensors_off_their_planes_mix_the_displacements():
    f = sensor_response(given_parameters({"plane3.offset": 0.05}), OMEGA)
    np.testing.assert_array_equal(f[:4], np.eye(8)[:4])
    assert f[4, 4] < 1.0
    np.testing.assert_allclose(f.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_array_equal(f[4, 1::2], 0.0)


def test_variables_of_a_controller_are_declared_once_for_all_gains(monkeypatch):
    """A search for gains asks for the parameters hundreds of times; equal loops have equal variables."""
    declared, declare = [], interface.parameter_variables
    monkeypatch.setattr(interface, "parameter_variables", lambda loop: declared.append(loop) or declare(loop))
    for gain in (1e6, 2e6):
        loop = ControlLoop(("once",), (SensorPlane("p", "p.x", "p.y", 0.1),), ("p",))
        assert parameters_of_loop(loop, {"once.k_b_x": gain}).axes[0].k_b == gain
    assert len(declared) == 1
