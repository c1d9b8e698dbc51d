"""Studies of the control loop of an upright pump: its axis along the shaft, apart from those across it."""

from functools import cache
from pathlib import Path

import control
import numpy as np
import pytest

from amb_analysis.linear.axial_loop import AxialLoop, AxialPlant
from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.responses import diagonal_response, response
from amb_analysis.linear.rotor_and_magnets import bearing_slopes
from amb_analysis.machine.channels import place_of
from amb_analysis.machine.demand_limits import demand_amplitude
from amb_analysis.machine.feedback import bearing_forces, demanded_currents
from amb_analysis.machine.frequency_response import Structure, frequency_response
from amb_analysis.machine.machine import machine_of
from amb_cosim import studies
from amb_cosim.controllers.laws import Law
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario

LEVITATION = Path(__file__).parent / "upright_pump" / "levitation.toml"
T = 50e-6  # s
KP, KI, KD, ROLL_OFF = 1.2e4, 1e5, 25.0, 2.0 * np.pi * 2000.0  # of the axial PID in its controller file
CORNER = 2.0 * np.pi * 300.0  # of the lag of eddy currents (rad/s)
HERTZ = np.geomspace(1.0, 9e3, 60)
ACROSS = ("lower.x", "lower.y", "upper.x", "upper.y")


@cache
def machine(**settings):
    scenario = load_scenario(str(LEVITATION)).machine()
    return machine_of(prepare_run(scenario, {name.replace("__", "."): value for name, value in settings.items()}))


def constants():
    """m (kg), K_i (N/A), K_s (N/m) and bandwidth (rad/s) of the axis."""
    parameters = machine().parameters[ACTUATOR]
    k_s, k_i = bearing_slopes("thrust", "z", parameters)
    return machine().rotor.mass, k_i, k_s, 2.0 * np.pi * parameters["thrust.bandwidth_z"]


def pid():
    """The axial law by Tustin's rule, and its delay of one sample."""
    s = control.tf("s")
    continuous = KP + KI / s + KD * s / (1.0 + s / ROLL_OFF)
    return -control.ss(control.c2d(continuous, T, "tustin")) * control.ss(control.tf([1.0], [1.0, 0.0], T))


def sampled_plant():
    m, k_i, k_s, bandwidth = constants()
    A = [[0.0, 1.0, 0.0], [k_s / m, 0.0, k_i / m], [0.0, 0.0, -bandwidth]]
    return control.c2d(control.ss(A, [[0.0], [0.0], [bandwidth]], [[1.0, 0.0, 0.0]], [[0.0]]), T, "zoh")


def independent():
    """S = 1/(1 - P K) by python-control, with the same constants."""
    points = np.exp(2j * np.pi * HERTZ * T)
    return np.array([1.0 / (1.0 - (sampled_plant() * pid())(z)) for z in points])


def test_the_loop_lists_the_axis_along_the_shaft_last():
    loop = machine().loop
    assert loop.axis_names == (*ACROSS, "thrust.z")
    assert loop.lateral_axes == loop.axes[:4]
    assert machine().magnets == ("lower", "upper")


def test_axial_sensitivity_is_that_of_python_control():
    ours = diagonal_response(machine().loop.sensitivity(), HERTZ)[4]
    np.testing.assert_allclose(ours, independent(), rtol=1e-9)


def test_axial_sensitivity_is_that_of_the_assessment_without_eddy_currents():
    K = control.ss(pid())
    m, k_i, k_s, bandwidth = constants()
    assessed = AxialLoop(AxialPlant(m, k_i, k_s, bandwidth), Law(K.A, K.B, K.C, K.D), T)
    ours = diagonal_response(machine().loop.sensitivity(), HERTZ)[4]
    np.testing.assert_allclose(ours, assessed.sensitivity(HERTZ), rtol=1e-9)
    (s,) = [s for s in assessed.vibrations if s.imag < np.pi / T * 0.999]
    result = studies.poles(str(LEVITATION), count=12, up_to="36000 rpm")
    (axial,) = [pole for pole in result.poles if "axial" in pole.whirl]
    assert set(axial.whirl) == {"axial"}  # at every speed, and never paired with a vibration across
    np.testing.assert_allclose(axial.frequencies, s.imag, rtol=1e-8)
    np.testing.assert_allclose(axial.damping_ratios, -s.real / abs(s), rtol=1e-8)


def test_eddy_currents_of_the_loop_are_those_of_the_assessment():
    """Poles and sensitivity with the same lag, which the loop takes from the actuator's parameter."""
    K, (m, k_i, k_s, bandwidth) = control.ss(pid()), constants()
    law = Law(K.A, K.B, K.C, K.D)
    with_lag, without = (AxialLoop(AxialPlant(m, k_i, k_s, bandwidth, omega), law, T) for omega in (CORNER, None))
    loop = machine(amb_actuator__thrust__eddy_current_corner=f"{CORNER} rad/s").loop
    np.testing.assert_allclose(diagonal_response(loop.sensitivity(), HERTZ)[4], with_lag.sensitivity(HERTZ), rtol=1e-6)
    found = loop.poles(0.0)
    for s in with_lag.vibrations[np.abs(with_lag.vibrations) < np.pi / T]:
        assert np.abs(found.s[found.is_axial] - s).min() < 1e-6 * abs(s)
    damping = [(-of.vibrations.real / np.abs(of.vibrations)).min() for of in (with_lag, without)]
    assert damping[0] < damping[1]


def test_the_axis_is_coupled_into_no_other():
    S = response(machine().loop.sensitivity(), HERTZ)
    assert np.max(np.abs(S[4, :4])) < 1e-12
    assert np.max(np.abs(S[:4, 4])) < 1e-12
    weaker = machine(**{"rolac_controller__thrust__i_z__gain": 0.8}).loop
    changed = diagonal_response(weaker.sensitivity(), HERTZ) - diagonal_response(machine().loop.sensitivity(), HERTZ)
    assert np.max(np.abs(changed[:4])) < 1e-9
    assert np.max(np.abs(changed[4])) > 0.05


def test_an_axial_feedback_of_the_wrong_sign_is_unstable_along_the_shaft():
    stability = machine(**{"rolac_controller__thrust__i_z__gain": -1.0}).loop.poles(1000.0).stability
    assert not stability.is_stable
    assert stability.place == "thrust.z"


def test_unbalance_makes_no_speed_critical_along_the_shaft():
    result = studies.poles(str(LEVITATION), count=12, up_to="36000 rpm")
    (number,) = [k for k, pole in enumerate(result.poles, 1) if "axial" in pole.whirl]
    frequency = result.poles[number - 1].frequencies[0]
    assert frequency < result.speeds[-1]  # it is crossed by the frequency of rotation
    assert number not in [critical.mode for critical in result.critical_speeds]


def test_fast_vibrations_of_an_upright_rotor_are_at_the_frequency_of_its_modes():
    """They are beyond half the sample rate, where the magnets hardly change the modes of the rotor."""
    result = machine().loop.poles(0.0)
    across = result.s[(result.s.imag > 0.0) & ~result.is_axial]
    A = machine().linear_components.parts([PLANT])[0].law.A
    fastest = np.max(np.linalg.eigvals(A).imag)
    assert fastest > np.pi / T
    assert np.max(across.imag) == pytest.approx(fastest, rel=0.01)


def places(*channels, is_input):
    return [place_of(name, unit, machine().rotor, is_input=is_input) for name, unit in channels]


def structure(loop):
    return Structure(machine().rotor, loop, 1000.0, None if loop == "free" else machine())


def axial_feedback(omega):
    """Current over z with the hold of the demands, in the frequency domain; and the amplifier."""
    K = np.array([pid()(np.exp(1j * w * T)) for w in omega])
    held = (1.0 - np.exp(-1j * omega * T)) / (1j * omega * T)
    return K * held / (1.0 + 1j * omega / constants()[3])


def test_responses_along_the_shaft_are_those_of_a_mass_on_its_magnet():
    m, k_i, k_s, _ = constants()
    omega = 2.0 * np.pi * HERTZ
    inputs, outputs = places(("thrust.f_z", "N"), is_input=True), places(("thrust.z", "m"), is_input=False)
    stiffness = {"free": 0.0, "open": -k_s, "closed": -k_s - k_i * axial_feedback(omega)}
    for loop, k in stiffness.items():
        ours = frequency_response(structure(loop), inputs, outputs, HERTZ)[:, 0, 0]
        np.testing.assert_allclose(ours, 1.0 / (k - m * omega**2), rtol=1e-9)


def test_a_push_along_the_shaft_demands_a_current_that_pushes_back():
    inputs, outputs = places(("thrust.f_z", "N"), is_input=True), places(("thrust.i_z", "A"), is_input=False)
    (current,) = frequency_response(structure("closed"), inputs, outputs, np.array([0.01]))[:, 0, 0]
    assert current == pytest.approx(-1.0 / constants()[1], rel=0.01)


def test_forces_across_the_shaft_do_not_move_it_along():
    inputs = places(("bell.f_x", "N"), ("thrust.f_z", "N"), is_input=True)
    outputs = places(("probe_upper.x", "m"), ("thrust.z", "m"), is_input=False)
    H = frequency_response(structure("closed"), inputs, outputs, HERTZ)
    assert np.max(np.abs(H[:, 0, 1])) == np.max(np.abs(H[:, 1, 0])) == 0.0
    names = f"{PLANT}.bell.f_x", f"{PLANT}.probe_upper.x"
    model = model_of(machine().linear_components.at(1000.0), [names[0]], [names[1]])
    slow = HERTZ < 200.0
    np.testing.assert_allclose(np.abs(H[slow, 0, 0]), np.abs(response(model, HERTZ[slow])[0, 0]), rtol=0.02)


def test_unbalance_demands_no_current_along_the_shaft():
    n = 2 * len(machine().z)
    assert demanded_currents(machine(), 1000.0, 1000.0).shape == (4, n)
    assert bearing_forces(machine(), 1000.0, 1000.0).shape == (n, n)
    assert demand_amplitude(machine(), "thrust", "z") == pytest.approx(1.5)


def test_linearisation_of_the_thrust_magnet_has_its_constants():
    result = studies.linearisation(str(LEVITATION), axis="thrust.z")
    _, k_i, k_s, _ = constants()
    assert (result.k_i, result.k_s) == pytest.approx((k_i, k_s), rel=1e-12)
    (face,) = {face.clearance for face in machine().rotor.faces}
    assert result.map.x[-1] == pytest.approx(face)


@pytest.mark.slow
def test_the_measured_sensitivity_along_the_shaft_is_the_computed_one():
    result = studies.sensitivity(str(LEVITATION))
    axis = result.axes["thrust.z"]
    assert list(result.axes) == [*ACROSS, "thrust.z"]
    assert axis.largest_difference_below_500_hz < 0.01
    assert axis.largest_difference < 0.02
