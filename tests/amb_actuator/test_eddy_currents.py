"""Eddy currents in the solid iron of a thrust magnet: the half-order lag, exact over steps of any length.

References: Mittag-Leffler's function E_1/2(-x) = exp(x^2) erfc(x) of a step, G(s) = 1/(1 + sqrt(s/omega_e)), and
integration of the lags as differential equations.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erfcx

from amb_actuator.actuator import constants_for, model_for
from amb_actuator.eddy_currents import LAG
from amb_actuator.interface import DYNAMIC, LINEAR, MEASURED, NONLINEAR
from fmi_export.model import Instance

H = 50e-6
CORNER = 120.0
OMEGA_E = 2.0 * math.pi * CORNER
GAP, BIAS = 0.5e-3, 2.5
MAGNET = {"turns_z": 60.0, "pole_area_z": 6e-4, "gap_z": GAP, "bias_current_z": BIAS, "static_current_z": 0.0}
MAGNET |= {"current_limit_z": 8.0, "half_angle_z": 0.0, "b_sat_z": 10.0, "eddy_current_corner": CORNER}
MAGNET |= {"resistance_z": 0.5, "inductance_z": 11e-3, "voltage_limit_z": 60.0, "bandwidth_z": 2000.0}


def magnet(law=LINEAR, **changes):
    made = Instance(model_for(("b",), "thrust"), constants_for(("b",), "thrust"))
    made["force_law"] = float(law)
    for name, value in (MAGNET | changes).items():
        made[f"thrust.{name}" if name.endswith("_z") or name in ("z", "eddy_current_corner") else name] = value
    made.initialise()
    return made


def advanced(made, duration, n=1):
    for k in range(n):
        made.step(k * duration / n, duration / n)
    return made["thrust.f_z"]


def response(s):
    poles, weights = OMEGA_E * np.array(LAG.poles), np.array(LAG.weights)
    return np.sum(weights * poles / (np.asarray(s)[..., None] + poles), axis=-1)


def test_sum_of_lags_is_within_its_stated_errors():
    for reach, error in ((1e2, 5e-4), (1e3, 1e-3), (1e4, 2.5e-3)):
        s = 1j * OMEGA_E * np.geomspace(1e-9, reach, 5003)
        assert np.abs(response(s) * (1.0 + np.sqrt(s / OMEGA_E)) - 1.0).max() < error
    assert math.fsum(LAG.weights) == pytest.approx(1.0, abs=1e-15)
    assert min(LAG.weights) > 0.0 < min(LAG.poles)


def test_phase_of_the_sum_tends_to_minus_45_degrees():
    assert np.degrees(np.angle(response(1j * 1e3 * OMEGA_E))) == pytest.approx(-45.0, abs=1.4)
    assert np.degrees(np.angle(response(1j * OMEGA_E))) == pytest.approx(-22.5, abs=0.05)


@pytest.mark.parametrize("law", [LINEAR, MEASURED, NONLINEAR])
@pytest.mark.parametrize("t", [H, 1e-3, 2e-2])
def test_force_after_a_step_of_current_follows_the_error_function(law, t):
    """F = K_i i (1 - E_1/2(-sqrt(omega_e t))), of all laws for a small current."""
    at_rest, made = magnet(law, eddy_current_corner=0.0), magnet(law)
    for each in (at_rest, made):
        each["thrust.i_z"] = 1e-3
    share = advanced(made, t) / advanced(at_rest, t)
    assert share == pytest.approx(1.0 - erfcx(math.sqrt(OMEGA_E * t)), rel=1e-3)


@pytest.mark.parametrize("law", [LINEAR, NONLINEAR])
def test_force_after_a_step_of_displacement_lags_as_that_of_a_current(law):
    """A rotor moves and stands still: the pull away from the centre grows with the flux, without a gradient."""
    at_rest, made = magnet(law, eddy_current_corner=0.0), magnet(law)
    made["thrust.z"] = at_rest["thrust.z"] = 1e-9
    full = advanced(at_rest, H)
    forces = [advanced(made, H) for _ in range(400)]
    shares = 1.0 - erfcx(np.sqrt(OMEGA_E * H * np.arange(1, 401)))
    np.testing.assert_allclose(np.array(forces[1:]) / full, shares[1:], atol=0.08)  # of the step's extrapolation
    np.testing.assert_allclose(np.array(forces[40:]) / full, shares[40:], atol=0.005)
    assert made["thrust.k_zz"] == 0.0 < at_rest["thrust.k_zz"]


@pytest.mark.parametrize("amplifier", [0.0, float(DYNAMIC)])
def test_steps_of_any_length_reach_the_same_force(amplifier):
    """Also with an amplifier that leaves its voltage limit within the step."""
    values = []
    for n in (1, 2, 40):
        made = magnet(NONLINEAR, amplifier=amplifier)
        made["thrust.i_z"], made["thrust.z"] = 2.0, 0.0
        values.append(advanced(made, 2e-3, n))
    assert values[1:] == pytest.approx(values[:1] * 2, rel=1e-11)


@pytest.mark.parametrize(("off", "volts"), [(False, 60.0), (False, 12.0), (True, 60.0)])
def test_flux_of_a_dynamic_amplifier_is_that_of_its_equations(off, volts):
    """Integrated: coil currents under their voltage limits, and each lag behind its coil's current."""
    h, R, L, omega = 3e-4, 0.5, 11e-3, 2.0 * math.pi * 2000.0
    made = magnet(NONLINEAR, amplifier=float(DYNAMIC), voltage_limit_z=volts, discharge_voltage_z=40.0)
    made["thrust.i_z"], made["thrust.amplifier_off_z"] = 1.5, float(off)
    force = advanced(made, h)
    poles, weights = OMEGA_E * np.array(LAG.poles), np.array(LAG.weights)

    def slopes(sign):
        def slope(t, y):
            i = y[0]
            if off:
                rate = (-40.0 - R * i) / L if i > 0.0 else 0.0
            else:
                u = np.clip(L * omega * (BIAS + sign * 1.5 - i) + R * i, -volts, volts)
                rate = (u - R * i) / L
            return np.concatenate([[rate], poles * (max(i, 0.0) - y[1:])])

        return slope

    pulls, start = [], np.full(len(poles) + 1, BIAS)
    for sign in (1.0, -1.0):
        y = solve_ivp(slopes(sign), (0.0, h), start, "LSODA", rtol=1e-9, atol=1e-11, max_step=1e-6)
        pulls.append(float(weights @ y.y[1:, -1]) ** 2)
    scale = 4e-7 * math.pi * 60.0**2 * 6e-4 / GAP**2
    expected = scale * (pulls[0] - pulls[1])
    assert force == pytest.approx(expected, rel=2e-6, abs=1e-6)


def test_pull_after_a_loss_of_power_decays_with_the_square_of_the_flux():
    made = magnet(NONLINEAR, z=0.1e-3, discharge_voltage_z=1e9)
    before = made["thrust.f_z"]
    made["thrust.amplifier_off_z"] = 1.0
    assert advanced(made, 1e-3) / before == pytest.approx(erfcx(math.sqrt(OMEGA_E * 1e-3)) ** 2, rel=2e-3)


def test_mean_force_of_a_step_is_the_average_of_its_parts():
    """Of the linear law, whose force is proportional to the flux."""
    whole, parts = (magnet(mean_current=1.0, amplifier=float(DYNAMIC)) for _ in range(2))
    whole["thrust.i_z"] = parts["thrust.i_z"] = 0.3
    mean = advanced(whole, 1e-3)
    assert mean == pytest.approx(np.mean([advanced(parts, 1e-5) for _ in range(100)]), rel=1e-6)


def test_force_on_a_vibrating_rotor_converges_with_the_square_of_the_step():
    """z = sin(omega t): the averages over steps tend to those of G(i omega) K_s z."""
    omega, amplitude = 2.0 * math.pi * 150.0, 1e-6
    k_s = magnet(eddy_current_corner=0.0)["thrust.k_zz"]
    transfer = complex(response(1j * omega))
    errors = []
    for h in (2e-4, 1e-4, 5e-5):
        made, forces = magnet(mean_current=1.0), []
        times = h * np.arange(round(0.4 / h))
        for t in times:
            made["thrust.z"] = amplitude * math.sin(omega * t)
            made.step(t, h)
            forces.append(made["thrust.f_z"])
        middle = times + 0.5 * h
        exact = k_s * amplitude * np.imag(transfer * np.exp(1j * omega * middle)) * np.sinc(omega * h / 2.0 / math.pi)
        late = times > 0.3
        errors.append(np.abs(np.array(forces)[late] - exact[late]).max() / (k_s * amplitude))
    assert errors[0] / errors[1] > 3.4 < errors[1] / errors[2]
    assert errors[2] < 1e-3


def test_iron_without_a_corner_has_no_lag():
    made = magnet(NONLINEAR, eddy_current_corner=0.0)
    made["thrust.i_z"], made["thrust.z"] = 1.0, 1e-5
    made.step(0.0, H)
    force = made["thrust.f_z"]
    made.step(H, H)
    assert made["thrust.f_z"] == force
    assert made["thrust.k_zz"] > 0.0
