"""Sensitivity measured in the co-simulation of the three FMUs against the one computed from the sampled linear loop."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amb_analysis.linear.responses import response
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.inputs import controlled
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from rotor_analysis.packaged_rotors import rotor_path
from tests.support.messages import raises_naming

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]


def study(**options: Any) -> dict[str, Any]:
    """Return sensitivities of the axes of the rig with a damped shaft at 90 rad/s, or with other options.

    Without damping of its bending modes, samples of 250 us destabilise some between 700 and 1415 Hz.
    """
    return studies.sensitivity(**({"rotor": "bath_rig", "speed": "90 rad/s"} | options)).as_dict()["axes"]


# Sampling alone is represented exactly; amplifiers are coupled with second order.
CASES: dict[str, tuple[dict[str, Any], float]] = {
    "sampling": ({}, 0.001),
    "sampling at high speed": ({"speed": "100 Hz"}, 0.001),
    "delay": ({"delay": True}, 0.001),
    "amplifiers": ({"amplifier": True}, 0.01),
    "amplifiers and delay, sampled twice as often": ({"amplifier": True, "delay": True, "sample_time": "125 us"}, 0.01),
    "anti-aliasing filter": (
        {"set": {"rolac_controller.chain.filter": True, "rolac_controller.chain.cutoff": "4 kHz"}},
        0.001,
    ),
    "nonlinear law, filtered derivative, integral": (
        {
            "set": {
                "amb_actuator.force_law": 2,
                "rolac_controller.derivative_time": "100 us",
                "rolac_controller.*.k_integral_?": 1e6,
            }
        },
        0.005,
    ),
}


def test_sensitivities_agree_with_sensors_beside_their_bearings(tmp_path) -> None:
    """A compressor whose sensors are three nodes inboard and outboard of its bearings."""
    text, rotor = rotor_path("compressor").read_text(encoding="utf-8"), tmp_path / "moved.toml"
    for name, at, moved in (("at_mb1", 8, 5), ("at_mb2", 49, 46)):
        text = text.replace(f'name = "{name}"\nnode = {at}', f'name = "{name}"\nnode = {moved}')
    rotor.write_text(text, encoding="utf-8")
    collocated, apart = (
        study(scenario="compressor_levitated", rotor=name, speed=None) for name in ("compressor", str(rotor))
    )
    for name, axis in apart.items():
        assert axis["largest_difference_below_500_hz"] < 0.001
        assert abs(axis["peak"] / collocated[name]["peak"] - 1.0) > 0.02


@pytest.mark.parametrize("name", CASES)
def test_measured_and_computed_sensitivity_agree(name: str) -> None:
    options, tolerance = CASES[name]
    axes = study(**options)
    assert set(axes) == {"mb1.x", "mb1.y", "mb2.x", "mb2.y"}
    for axis in axes.values():
        assert axis["largest_difference_below_500_hz"] < tolerance
        assert axis["measured_peak"] == pytest.approx(axis["peak"], rel=tolerance)


def test_sensitivity_with_a_share_of_a_sample_of_delay_is_measured(tmp_path) -> None:
    """Demands 0.3 samples late, not a multiple of the measurement's steps: |S| at demands and sensors is the same."""
    text = (ROOT / "examples/controllers/lead_notches.toml").read_text(encoding="utf-8")
    file = tmp_path / "late.toml"
    file.write_text("delay = 0.3\n" + text, encoding="utf-8")
    result = studies.sensitivity("compressor_levitated", controller=file)
    for axis in result.axes.values():
        assert axis.largest_difference_below_500_hz < 0.002
        assert axis.largest_difference < 0.02
    loop = Machine(prepare_run(controlled("compressor_levitated", None, file))).loop
    ends = len(loop.demands)
    at_sensors = response(loop.closed, result.frequencies)[ends:, ends:]
    for k, axis in enumerate(result.axes.values()):
        np.testing.assert_allclose(np.abs(at_sensors[k, k]), axis.computed, rtol=1e-6)


def test_contact_during_the_measurement_is_reported() -> None:
    with raises_naming(ValueError, "touched", "during the measurement"):
        study(set={"rotor_contact.rb1.clearance": "1 um"})
