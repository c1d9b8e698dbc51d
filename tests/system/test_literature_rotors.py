"""Rotors of the literature that come with the package: their scenarios rub, recover, and close the energy balance."""

import math
from typing import Any

import numpy as np
import pytest

import amb_cosim
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.response import unbalance_response
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor

CONTACTS = {
    "nelson_mcvaugh_rub": {"rim"},
    "compressor_touchdown": {"td1", "td2", "seal"},
    "compressor_levitated_touchdown": {"td1", "td2", "seal"},
}


def forward_amplitude(result: Any, x: str, y: str) -> complex:
    """Return r_f of x + i y = r_f exp(i theta), the mean over the last ten cycles (m)."""
    last = result.signals["cycle"].values > result.signals["cycle"].values[-1] - 10.0
    position, theta = (
        result.signals[f"rotor_contact.{x}"].values + 1j * result.signals[f"rotor_contact.{y}"].values,
        result.signals["rotor_contact.theta"].values,
    )
    return complex(np.mean((position * np.exp(-1j * theta))[last]))


def test_unbalance_response_agrees_with_analysis_near_resonance() -> None:
    """Amplitude and phase, which turns by 180 degrees there, of disc and bearings; other direction, other sign."""
    result = amb_cosim.run("nelson_mcvaugh_free", progress=False)
    rotor, Omega = load_rotor("nelson_mcvaugh"), 17000.0 * math.pi / 30.0
    support = supported_rotor(rotor.on_equal_bearings(4.378e7, 2000.0))
    places = {"at_disc": 5, "b1": 11, "b2": 15}
    x, y = unbalance_response(support, {5: 2e-6}, np.array([Omega]), tuple(places.values()))[0].reshape(-1, 2).T
    for place, x_place, y_place in zip(places, x, y, strict=True):
        expected = 0.5 * (x_place + 1j * y_place)
        matches = forward_amplitude(result, f"{place}.x", f"{place}.y")
        assert abs(matches - expected) < 1e-2 * abs(expected), place
    assert result.summary.first_contact is None


@pytest.mark.parametrize("name", CONTACTS)
def test_the_rotor_rubs_recovers_and_balances_its_energy(name: str) -> None:
    summary = amb_cosim.run(name, progress=False).summary
    assert {site for site, force in summary.peak_contact_force.items() if force and force > 100.0} == CONTACTS[name]
    assert all(share and share > 0.1 for share in summary.site_share.values())
    assert summary.recovery == "recovered"
    assert summary.energy_balance is not None
    assert summary.energy_balance < 1e-6
    assert summary.energy is not None
    assert summary.energy["friction"] > 10.0 * summary.energy["impact"] > 0.0


def test_pid_holds_the_compressor_without_contact() -> None:
    summary = amb_cosim.run("compressor_levitated", progress=False).summary
    assert summary.recovery == "prevented"
    assert all(0.02 < radius < 0.06 for radius in summary.orbit_largest.values() if radius is not None)


def test_the_controller_assumes_the_constants_of_its_magnets() -> None:
    parameters = load_scenario("compressor_levitated").parameters
    magnet = {"turns": 48.0, "pole_area": 45e-4, "gap": 0.5e-3, "bias_current": 5.0, "static_current": 1.5}
    k_s, k_i = linear_constants(axis_parameters(current_limit=11.5, **magnet))
    controller = parameters["rolac_controller"]
    assert float(str(controller["*.k_s_?"]).split()[0]) == pytest.approx(k_s, rel=1e-3)
    assert float(str(controller["*.k_i_?"]).split()[0]) == pytest.approx(k_i, rel=1e-3)
    assert str(parameters["amb_actuator"]["*.turns_?"]) == "48"
