"""Sensitivity measured in the co-simulation of the three FMUs against the one computed from the sampled linear loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytestmark = pytest.mark.slow


def studied(**options: Any) -> dict[str, Any]:
    """Peaks and differences of all axes, or what the study refuses."""
    from pathlib import Path

    from amb_cosim import studies
    from rotor_analysis.packaged_rotors import rotor_path

    options = {"speed": "90 rad/s"} | options
    if moved := options.pop("sensor_nodes", None):
        text = rotor_path(options["rotor"]).read_text(encoding="utf-8")
        for of_bearing, node in moved.items():
            text = text.replace(of_bearing, f"{of_bearing.partition('node')[0]}node = {node}")
        options["rotor"] = str(Path("moved.toml").absolute())
        Path(options["rotor"]).write_text(text, encoding="utf-8")
    try:
        axes = studies.sensitivity(**options).as_dict()["axes"]
    except ValueError as error:
        return {"refused": str(error)}
    keys = ("peak", "peak_frequency_hz", "zone", "largest_difference_below_500_hz", "measured")
    return {name: {key: axis[key] for key in keys} for name, axis in axes.items()}


@pytest.fixture(scope="module")
def study(run_once: Callable[..., Any]) -> Callable[..., dict[str, Any]]:
    return lambda **options: run_once(studied, timeout=300, **options)


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
        0.05,
    ),
}


def test_measured_sensitivity_is_the_computed_one_with_sensors_beside_their_bearings(study: Any) -> None:
    """A compressor whose sensors are three nodes inboard and outboard of its bearings."""
    moved = {'name = "at_mb1"\nnode = 8': 5, 'name = "at_mb2"\nnode = 49': 46}
    of_compressor = {"scenario": "compressor_levitated", "rotor": "compressor", "speed": None}
    collocated, apart = study(**of_compressor), study(**of_compressor, sensor_nodes=moved)
    for name, axis in apart.items():
        assert axis["largest_difference_below_500_hz"] < 0.001
        assert abs(axis["peak"] / collocated[name]["peak"] - 1.0) > 0.02


@pytest.mark.parametrize("name", CASES)
def test_measured_sensitivity_is_the_computed_one(study: Any, name: str) -> None:
    options, tolerance = CASES[name]
    axes = study(**options)
    assert set(axes) == {"mb1.x", "mb1.y", "mb2.x", "mb2.y"}
    for axis in axes.values():
        assert axis["largest_difference_below_500_hz"] < tolerance
        assert max(axis["measured"]) == pytest.approx(axis["peak"], rel=0.03)


def test_contact_during_the_measurement_is_reported(study: Any) -> None:
    answer = study(set={"rotor_contact.rb1.clearance": "5 um"})
    assert "the rotor touched a retainer or another site during the measurement" in answer["refused"]
