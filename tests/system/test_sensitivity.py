"""Sensitivity measured in the co-simulation of the three FMUs against the one computed from the sampled linear loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytestmark = pytest.mark.slow


def studied(**options: Any) -> dict[str, Any]:
    """Peaks and differences of the four axes, or what the study refuses."""
    from amb_cosim import studies

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
    "amplifiers and delay, sampled twice as often": (
        {"amplifier": True, "delay": True, "sample_time": "125 us"},
        0.01,
    ),
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
    assert "the rotor touched its retainer during the measurement" in answer["refused"]
